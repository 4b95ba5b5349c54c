// BVH (Biovision hierarchy) reader: skeleton, channels, frames, and joint positions by forward
// kinematics.
// Units and axes are the file's own (usually centimetres, y up); human_motion.h turns them into
// metres, z up.
#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <string>
#include <vector>

namespace sanso::motion {

/// A clip that cannot be used. The message names file, line, what was found, what was expected.
struct ClipError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class BvhChannel { x_position, y_position, z_position, x_rotation, y_rotation, z_rotation };

struct BvhJoint {
  std::string name;
  int parent = -1;                   // index into joints; -1: root
  Eigen::Vector3d offset{0, 0, 0};   // from the parent, in the parent's axes
  std::vector<BvhChannel> channels;  // in file order; rotations multiply from left to right
  int first_channel = 0;             // column of the first one in `frames`
};

struct BvhClip {
  std::string file;
  double frame_time_s = 0.0;
  std::vector<BvhJoint> joints;  // parents before children; end sites are left out
  // one row of channel values per frame (position in file units, angles deg)
  std::vector<std::vector<double>> frames;

  /// Index of a joint. Throws ClipError naming the joints there are.
  int joint(const std::string& name) const;
  /// World positions of all joints in one frame, file units and axes.
  std::vector<Eigen::Vector3d> positions(std::size_t frame) const;
};

BvhClip read_bvh(const std::string& path);
/// The same from text; `name` stands for the file in messages.
BvhClip parse_bvh(const std::string& text, const std::string& name);

}  // namespace sanso::motion
