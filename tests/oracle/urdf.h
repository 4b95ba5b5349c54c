// A robot description as people have it: URDF text to the generic tree that every algorithm of
// shared/model reads.
#pragma once

#include <string>
#include <vector>

#include "tests/oracle/tree.h"

namespace sanso::model {

enum class Base { fixed, floating };

struct UrdfRobot {
  // links that hang on fixed joints are joined to the link that carries them
  Tree tree;
  std::vector<std::string> joint_names;  // [num_joints] of tree.joints, parents first
};

/// Reads URDF (revolute, continuous, prismatic and fixed joints, up to kMaxTreeJoints movable
/// ones). URDF knows no rotor: every armature is zero. With Base::fixed the root link carries no
/// inertia.
/// Errors: files::InputError names the file, the link or joint, the value and what was
/// expected.
UrdfRobot read_urdf(const std::string& path, Base base);

/// The same from text; `name` stands for the file in errors.
UrdfRobot parse_urdf(const std::string& text, const std::string& name, Base base);

}  // namespace sanso::model
