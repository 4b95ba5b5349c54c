// Arms and head are in no state of the controller: they are drawn where the robot is put down.
#include "tools/page/scene.h"

#include <nlohmann/json.hpp>

#include "shared/model/joints.h"
#include "tools/emulator/emulated_robot.h"
#include "tools/plant/body_data.h"
#include "tools/plant/mjcf.h"

namespace sanso::page {

nlohmann::json scene_of(const plant::World& world) {
  nlohmann::json fixed = nlohmann::json::object(), joints = nlohmann::json::array();
  const emulator::Placement standing = emulator::walkready();
  for (const plant::JointData& joint : plant::op3_body().joints)
    fixed[joint.name] = standing.q.at(static_cast<std::size_t>(joint.servo_id - 1));
  for (const model::JointInfo& joint : model::kJoints) joints.push_back(joint.name);
  return {{"mjcf", plant::make_mjcf(world)}, {"fixed", fixed}, {"joints", joints}};
}

}  // namespace sanso::page
