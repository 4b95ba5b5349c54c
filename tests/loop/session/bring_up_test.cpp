// Bring-up on the emulated robot: poses go where they say, and what is found there is what was put
// into the plant, within the deviation that stands beside it. The truth is read by the test alone.
#include <fstream>
#include <map>

#include "host/learn/session/bring_up.h"
#include "shared/model/joints.h"
#include "shared/model/op3_kinematics.h"
#include "tests/loop/support/loop_fixture.h"
#include "tests/support/temp_folder.h"
#include "tools/plant/plant.h"
#include "tools/plant/servo_birth.h"

namespace sanso::loop {
namespace {

using learn::TrunkShift;

struct BringUp : testing::Test {
  /// A world of its own, from the text of a world file.
  std::string world(const std::string& text) {
    const std::filesystem::path path = temporary.path() / "world.toml";
    std::ofstream(path) << text;
    return path.string();
  }
  test::TempFolder temporary;
};

TEST_F(BringUp, ThePosesGoWhereTheySay) {
  for (const char* world : {"nominal", "lab"}) {
    inprocess::InProcessAccess access(world);
    link::RobotLink& link = access.place(learn::shifted_stand({}), 1);
    learn::BringUpSettings at_once;  // arms; the poses themselves come below
    at_once.forward_m = at_once.side_m = at_once.squat_m = 0.0;
    at_once.hold_s = 0.2;
    const learn::HeldPoses none = learn::hold_poses(link, at_once, {});
    ASSERT_EQ(none.stopped, "") << world;
    const auto at = [&](const TrunkShift& shift) {
      learn::hold_pose(link, shift, 1.5);
      return access.robot().robot().truth();
    };
    const emulator::Truth stand = at({}), forward = at({0.02, 0, 0}), left = at({0.01, 0.015, 0}),
                          right = at({0.01, -0.015, 0}), low = at({0.01, 0, -0.02});
    EXPECT_NEAR(forward.p_world_base[0] - stand.p_world_base[0], 0.02, 0.01) << world;
    EXPECT_GT(left.p_world_base[1] - right.p_world_base[1], 0.02) << world;
    EXPECT_NEAR(low.p_world_base[2] - stand.p_world_base[2], -0.02, 0.008) << world;
    EXPECT_EQ(low.other_contacts, 0) << world;
  }
}

/// What was put into a world, in the names of the figures.
std::map<std::string, double> truth_of(const plant::World& world) {
  const model::State stand = model::standing_state();
  std::array<double, model::kNumJoints> legs{};
  for (int j = 0; j < model::kNumJoints; ++j)
    legs[static_cast<std::size_t>(j)] = stand[model::kXJoint + j];
  const plant::World nominal_world = plant::load_world("nominal");
  plant::Plant plant(world);
  plant.place(emulator::with_legs(legs).q, 0, 0, 0);
  using plant::operator-;
  const plant::Vec3 com = plant.center_of_mass() - plant.base().p_world_base;
  const double stiffness = nominal_world.servo.p_divisor / world.servo.p_divisor *
                           world.supply.voltage_V / nominal_world.supply.voltage_V;
  std::map<std::string, double> truth{
      {"stiffness_over_mass", stiffness * plant::Plant(nominal_world).mass_kg() / plant.mass_kg()},
      {"com_x", com[0]},
      {"com_y", com[1]}};
  for (int foot = 0; foot < 2; ++foot)
    for (int axis = 0; axis < 2; ++axis) {
      double turned = 0.0;
      for (int j = 6 * foot; j < 6 * foot + 6; ++j)
        if (model::kOp3Joints[j].axis == axis)
          turned +=
              model::kOp3Joints[j].sign *
              plant::birth_of(world.servo, model::kJoints[static_cast<std::size_t>(j)].servo_id)
                  .zero_offset_rad;
      truth[std::string("sole:") + (foot == 0 ? "right" : "left") +
            (axis == 0 ? "_roll" : "_pitch")] = turned;
    }
  return truth;
}

TEST_F(BringUp, WhatIsInThePlantIsFoundWithinItsDeviation) {
  // without dry friction, of which a held pose shows only a bound
  const std::vector<std::string> names{
      "nominal", world("name = \"a\"\n[body]\ntorso_com_offset_m = [0.012, 0.006, 0.0]\n[servo]\n"
                       "p_divisor = 160.0\nzero_offset_rad = 0.012\nspread_seed = 4\n")};
  for (const std::string& name : names) {
    inprocess::InProcessAccess access(name);
    link::RobotLink& link = access.place(learn::shifted_stand({}), 1);
    const learn::BringUpSettings settings;
    const learn::HeldPoses held = learn::hold_poses(link, settings, {});
    ASSERT_EQ(held.stopped, "") << name;
    const learn::ParameterMap map(model::nominal_parameters());
    const learn::StaticBalance balance = learn::balance_of(held.poses, map, settings.balance);
    const std::map<std::string, double> truth = truth_of(plant::load_world(name));
    for (const learn::StaticFigure& f : learn::figures_of(balance, map, settings.balance)) {
      if (truth.count(f.name) == 0) continue;
      EXPECT_LT(std::abs(f.value - truth.at(f.name)), 3.0 * f.deviation)
          << name << ": " << f.name << " found " << f.value << " +- " << f.deviation << ", is "
          << truth.at(f.name);
      EXPECT_TRUE(f.seen()) << name << ": " << f.name;
    }
  }
}

}  // namespace
}  // namespace sanso::loop
