// A robot whose base moves: its tree, the body that floats, and the shapes that can touch the
// ground.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/model_folder/robot_tree.h"

namespace sanso::diagnose {

/// Of a whole robot; nothing there is sized by it.
inline constexpr int kMaxBodyJoints = 64;

/// Points of a link that can touch, each a ball of `radius` (0: a corner). In the frame of the
/// joint that carries the link; of the base: in base axes from the root link's origin.
struct CollisionShape {
  std::string link;
  int joint = -1;  // -1 = the base
  std::vector<Vec3> points;
  double radius = 0.0;
};

struct BodyTree {
  RobotTree tree;
  std::string root;  // the link that floats
  BodyInertia base;  // of it and all that is fixed to it
  std::vector<CollisionShape> shapes;
  std::vector<std::string> meshes;  // links whose shape is a mesh, which is not read
};

/// Reads URDF text; a robot without a movable joint is one body. `rim_points` of a cylinder.
/// Throws files::InputError.
BodyTree body_tree_from_urdf(const std::string& urdf, const std::string& file, int rim_points);

/// Corners of a box of this size about its centre.
std::vector<Vec3> box_corners(const Vec3& size);
/// As many points on either rim of a cylinder along z.
std::vector<Vec3> cylinder_rims(double radius, double length, int points);

}  // namespace sanso::diagnose
