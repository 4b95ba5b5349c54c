// The robot's links and joints as the maker publishes them (data/*.csv), read at start.
#pragma once

#include <string>
#include <vector>

#include "tools/plant/vec.h"

namespace sanso::plant {

struct LinkData {
  std::string name, parent;
  double mass_kg = 0;
  Vec3 com_m{};
  double ixx = 0, ixy = 0, ixz = 0, iyy = 0, iyz = 0, izz = 0;  // about the COM, link axes, kg m^2
};

struct JointData {
  std::string name, parent, child;
  Vec3 origin_m{}, axis{};
  int servo_id = 0;
};

struct BodyData {
  std::vector<LinkData> links;    // massive links only
  std::vector<JointData> joints;  // revolute only
};

/// The OP3's figures. Throws WorldError when the built-in tables do not parse.
const BodyData& op3_body();

/// Files compiled into the program: "op3_links.csv", "lab.toml", ... Empty when there is none of
/// that name.
const std::string& built_in_file(const std::string& name);

}  // namespace sanso::plant
