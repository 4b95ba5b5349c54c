// Builds a profile from lines and arcs that follow one another; height, slope and curvature at x
// are then a search for the segment and two lines of geometry.
#include "shared/model/ground.h"

#include <cmath>

namespace sanso::model {
namespace {

constexpr double kSteepest_rad = 0.785398;
constexpr double kLevel_m = 1e-4;  // at the start: figures in files are rounded

const GroundSegment& segment_at(const Ground& g, double x) {
  int i = 0;
  while (i + 1 < g.num_segments && x >= g.segment[i + 1].x_start) ++i;
  return g.segment[i];
}

double end_sin(const GroundSegment& s, double x) {
  return s.sin_slope + s.curvature * (x - s.x_start);
}

/// Appends segments, and remembers the first reason why that is not possible.
class ProfileBuilder {
 public:
  ProfileBuilder(const GroundCorner* corners, int count, Ground& ground)
      : corners_(corners), count_(count), ground_(ground) {
    ground_.num_segments = 0;
  }

  GroundDefect build() {
    if (count_ < 2) return {"too few points", "point", "at least two [[point]]", 0};
    double from = corners_[0].x;  // where the arc of the corner before ends
    for (int i = 0; i + 1 < count_ && !defect_.what; ++i) from = line(i, from);
    const double start = defect_.what ? 0.0 : ground_height(ground_, 0.0);
    if (!defect_.what && std::fabs(start) > kLevel_m)
      complain("start is not level with zero", "z_m", "height 0 at x = 0, where the robot stands",
               0);
    return defect_;
  }

 private:
  void complain(const char* what, const char* key, const char* expected, int corner) {
    if (!defect_.what) defect_ = {what, key, expected, corner};
  }
  void append(double x, double z, double sin_slope, double curvature) {
    if (ground_.num_segments == kMaxGroundSegments) {
      complain("too many lines and arcs", "x_m", "at most 16 of them", 0);
      return;
    }
    ground_.segment[ground_.num_segments++] = {x, z, sin_slope, curvature};
  }
  bool is_step(int i) const { return corners_[i + 1].x == corners_[i].x; }
  double angle(int i) const {
    return std::atan2(corners_[i + 1].z - corners_[i].z, corners_[i + 1].x - corners_[i].x);
  }

  /// The line from corner i and the arc at its end; returns where the next line starts.
  double line(int i, double from) {
    const GroundCorner& a = corners_[i];
    const GroundCorner& b = corners_[i + 1];
    const bool last = i + 2 == count_;
    if (b.x < a.x)
      complain("points out of order", "x_m", "x at least that of the point before", i + 1);
    if (is_step(i)) {
      if (a.radius > 0.0 || b.radius > 0.0)
        complain("arc at a step", "radius_m", "none at a vertical step", i + 1);
      if (last || i == 0)
        complain("profile ends in a step", "x_m", "a line before and behind it", i + 1);
      return b.x;
    }
    const double slope = angle(i), s = std::sin(slope);
    if (std::fabs(slope) > kSteepest_rad)
      complain("too steep", "z_m", "at most 45 degrees, or a vertical step", i + 1);
    append(from, a.z + (from - a.x) * std::tan(slope), s, 0.0);
    if (last || b.radius == 0.0 || is_step(i + 1)) {
      if (b.radius > 0.0) complain("arc at an end", "radius_m", "a line on both sides", i + 1);
      return b.x;
    }
    const double turn = angle(i + 1) - slope;
    const double tangent = b.radius * std::tan(0.5 * std::fabs(turn));
    const double arc_from = b.x - tangent * std::cos(slope);
    const double arc_to = b.x + tangent * std::cos(angle(i + 1));
    if (arc_from < from || arc_to > corners_[i + 2].x)
      complain("arc does not fit", "radius_m", "a smaller radius or longer lines", i + 1);
    append(arc_from, b.z - tangent * s, s, std::copysign(1.0 / b.radius, turn));
    return arc_to;
  }

  const GroundCorner* corners_;
  int count_;
  Ground& ground_;
  GroundDefect defect_;
};

}  // namespace

Ground make_plane(double z) {
  Ground g;
  g.segment[0].z = z;
  return g;
}

GroundDefect make_profile(const GroundCorner* corners, int count, Ground& ground) {
  return ProfileBuilder(corners, count, ground).build();
}

double ground_height(const Ground& ground, double x) {
  const GroundSegment& s = segment_at(ground, x);
  return s.z +
         (x - s.x_start) * std::tan(0.5 * (std::asin(s.sin_slope) + std::asin(end_sin(s, x))));
}

double ground_slope(const Ground& ground, double x) {
  return std::tan(std::asin(end_sin(segment_at(ground, x), x)));
}

}  // namespace sanso::model
