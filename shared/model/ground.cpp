// Builds each ground from lines and arcs that follow one another; height, slope and curvature at
// x are then a search for the segment and two lines of geometry.
#include "shared/model/ground.h"

#include <cmath>

namespace sanso::model {
namespace {

// Radii of the transitions [m]: at 1.3 m/s the body turns with at most 1.6 rad/s, and a 0.1 m sole
// sags under 2 mm.
constexpr double kConvexRadius = 0.8, kConcaveRadius = 1.0;
constexpr double kKickerStraight = 0.09;  // m, so that the pitch rate dies out before the lip

// Appends segments so that each starts where the previous one ends.
class ProfileBuilder {
 public:
  void line(double length) { append(0.0, length); }
  void arc_to(double slope_angle, double radius) {
    const double target = std::sin(slope_angle), sign = target > sin_slope_ ? 1.0 : -1.0;
    append(sign / radius, std::abs(target - sin_slope_) * radius);
  }
  void step(double dz) { z_ += dz; }
  void level_off() { sin_slope_ = 0.0; }
  double z() const { return z_; }
  /// Shifts the whole profile so that its end lies at height zero.
  Ground finish() {
    append(0.0, 0.0);
    for (int i = 0; i < ground_.num_segments; ++i) ground_.segment[i].z -= z_;
    return ground_;
  }

 private:
  void append(double curvature, double length) {
    if (count_ < kMaxGroundSegments) ground_.segment[count_++] = {x_, z_, sin_slope_, curvature};
    ground_.num_segments = count_;
    const double end_sin = sin_slope_ + curvature * length;
    z_ += length * std::tan(0.5 * (std::asin(sin_slope_) + std::asin(end_sin)));
    x_ += length;
    sin_slope_ = end_sin;
  }
  Ground ground_;
  int count_ = 0;
  double x_ = 0, z_ = 0, sin_slope_ = 0;
};

// Height lost on the two transition arcs of a slope.
double arc_drop(double angle, double radius) { return radius * (1.0 - std::cos(angle)); }

const GroundSegment& segment_at(const Ground& g, double x) {
  int i = 0;
  while (i + 1 < g.num_segments && x >= g.segment[i + 1].x_start) ++i;
  return g.segment[i];
}

double end_sin(const GroundSegment& s, double x) {
  return s.sin_slope + s.curvature * (x - s.x_start);
}

}  // namespace

Ground make_plane(double z) {
  Ground g;
  g.segment[0].z = z;
  return g;
}

Ground make_ramp(double drop, double angle, double top_length) {
  const double straight = drop - arc_drop(angle, kConvexRadius) - arc_drop(angle, kConcaveRadius);
  ProfileBuilder b;
  b.line(top_length);
  b.arc_to(-angle, kConvexRadius);
  b.line(std::fmax(0.0, straight) / std::tan(angle));
  b.arc_to(0.0, kConcaveRadius);
  return b.finish();
}

Ground make_jump_ramp(double drop, double angle, double exit_angle, double lip_step,
                      double top_length) {
  // net drop from the top to the lip: the run-in must lose what the kicker gains
  const double gained =
      arc_drop(exit_angle, kConcaveRadius) + kKickerStraight * std::tan(exit_angle);
  const double straight =
      drop + gained - arc_drop(angle, kConvexRadius) - arc_drop(angle, kConcaveRadius);
  ProfileBuilder b;
  b.line(top_length);
  b.arc_to(-angle, kConvexRadius);
  b.line(std::fmax(0.0, straight) / std::tan(angle));
  b.arc_to(exit_angle, kConcaveRadius);
  b.line(kKickerStraight);
  b.step(-lip_step);
  b.level_off();
  return b.finish();
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
