// The ground as a height function of world x (the same for every y): plane, ramp, jump ramp, or a
// table of heights.
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
/// Level top, convex arc into the slope, straight, concave arc into a level run-out at height 0.
/// `drop` [m] from top to run-out, `angle` [rad], the level top ends at x = top_length.
Ground make_ramp(double drop = 0.10, double angle = 0.2094, double top_length = 0.30);
/// The same run-in, then a concave arc into a kicker of `exit_angle`, its straight last part, a
/// vertical step down of `lip_step` and a level landing at height 0.
Ground make_jump_ramp(double drop = 0.11, double angle = 0.2094, double exit_angle = 0.1745,
                      double lip_step = 0.03, double top_length = 0.30);

/// Height [m] and slope dz/dx at x: the plain scalar form for drivers, references and plots.
double ground_height(const Ground& ground, double x);
double ground_slope(const Ground& ground, double x);

}  // namespace sanso::model
