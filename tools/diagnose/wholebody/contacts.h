// Which points of the robot touch the ground when, from poses and shapes alone.
#pragma once

#include <vector>

#include "tools/diagnose/wholebody/whole_data.h"

namespace sanso::diagnose {

/// A point that can touch, in the frame of its joint.
struct TouchPoint {
  std::string link;
  int joint = -1;
  V3 at = V3::Zero();
  double radius = 0.0;
};
/// The points of all collision shapes, each with its shape's radius, m.
std::vector<TouchPoint> touch_points(const WholeBody& body);

/// Unit vector against gravity, world axes; zero gravity: z.
V3 upwards(const WholeBody& body);

/// By row: height of the lowest point above the ground and which it is, and of the second lowest.
struct Clearance {
  std::vector<double> lowest, second;
  std::vector<int> point;
  double ground = 0.0;  // height that was used
  bool stated = false;  // by the model, else taken from the lowest rows
};
/// Needs poses and at least one shape. `pose_scale`: recorded base positions over true ones; the
/// heights are true lengths, m.
Clearance clearance(const WholeRecording& r, const WholeBody& body, double pose_scale,
                    const WholeSettings& settings);

/// Rows [first, last) during which something holds.
struct Span {
  std::size_t first = 0, last = 0;
  std::size_t rows() const { return last - first; }
};
/// Longest runs of rows of one piece with `holds`.
std::vector<Span> spans(const WholeRecording& r, const std::vector<char>& holds);

/// Nothing touches, with the ends cut off by which a tracker spreads impacts.
std::vector<Span> flights(const WholeRecording& r, const Clearance& c,
                          const WholeSettings& settings);

/// Normal of a foot's lowest face in the frame of its joint, pointing out of the ground; nothing
/// where the shape has no flat face below.
std::optional<V3> sole_normal(const WholeBody& body, int joint, const std::string& link);

}  // namespace sanso::diagnose
