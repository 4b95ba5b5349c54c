// The figures of a tree that do not change while it moves, as plain numbers: every instruction
// set's copy of the simulation reads them.
#pragma once

#include "tools/diagnose/model_folder/robot_tree.h"

namespace sanso::diagnose {

/// Mass properties of one link, link axes.
struct BodyFigures {
  double mass = 0.0;          // kg
  double com[3] = {0, 0, 0};  // m
  double I[6] = {};           // kg m^2 about the centre of mass: xx yy zz xy xz yz
};

/// One joint.
struct JointFigures {
  int parent = -1;  // -1: the base
  bool prismatic = false;
  double A[9], B[9], C[9];  // R_parent_link(q) = A + sin(q) B + cos(q) C, row by row
  double p_parent_joint[3], axis_parent[3];
};

struct TreeFigures {
  std::size_t n = 0;
  double gravity[3];  // acceleration of free fall in base axes, m/s^2
  std::size_t branches = 0;
  /// Joints [branch_begin[b], branch_begin[b + 1]) hang on the base by themselves.
  std::size_t branch_begin[kMaxJoints + 1];
  std::size_t root[kMaxJoints];  // first joint of the branch a joint belongs to
  JointFigures joint[kMaxJoints];
  BodyFigures body[kMaxJoints];
  bool lone_hinge = false;  // one revolute joint alone
};

/// `gravity`: acceleration of free fall in base axes, m/s^2.
TreeFigures tree_figures(const RobotTree& tree, const Vec3& gravity);
/// In the link's axes, as it is given.
BodyFigures body_figures(const BodyInertia& body);

}  // namespace sanso::diagnose
