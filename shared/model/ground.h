// The ground as a height function of world x (the same for every y): a plane, or a profile of
// corners as the files of shared/grounds describe it.
// Made of segments of constant curvature: straight lines and circular arcs.
#pragma once

namespace sanso::model {

/// From x_start on (until the next segment) the surface starts at height z with sine of slope
/// `sin_slope` and turns with `curvature` [1/m] (positive: concave, turning upwards). With s =
/// sin_slope + curvature (x - x_start), the sine of the slope at x, z(x) = z + (x - x_start) tan of
/// half the sum of both slopes: exact on lines and arcs alike.
struct GroundSegment {
  double x_start;    // m
  double z;          // m
  double sin_slope;  // -
  double curvature;  // 1/m
};

inline constexpr int kMaxGroundSegments = 16;

struct Ground {
  int num_segments = 1;  // 1: a plane through segment 0; segments are sorted by x_start
  GroundSegment segment[kMaxGroundSegments] = {};
};

/// Level floor at height z [m].
Ground make_plane(double z = 0.0);

/// A corner of a profile: the lines before and behind it meet at (x, z) and are joined by an arc of
/// `radius` [m]; 0: a kink. Two corners at one x are a vertical step.
struct GroundCorner {
  double x, z;
  double radius;
};

/// Why a profile is none, for whoever reads it from a file: the key and the corner meant, what is
/// wrong and what was expected. `what` is null when all is well.
struct GroundDefect {
  const char* what = nullptr;
  const char* key = "";
  const char* expected = "";
  int corner = 0;
};

/// Lines through the corners, arcs in them; first and last line go on for ever. The height at x = 0
/// must be 0 within 1e-4 m.
GroundDefect make_profile(const GroundCorner* corners, int count, Ground& ground);

/// Height [m] and slope dz/dx at x: the plain scalar form for drivers, references and plots.
double ground_height(const Ground& ground, double x);
double ground_slope(const Ground& ground, double x);

}  // namespace sanso::model
