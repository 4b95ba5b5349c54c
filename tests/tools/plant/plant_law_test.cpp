// Physics laws of the emulated robot: free fall, momentum, standing still, symmetry, contact
// forces.
#include "tools/plant/plant.h"

#include <gtest/gtest.h>

#include "tools/plant/mjcf.h"

namespace sanso::plant {
namespace {

std::array<double, kNumServos> crouched() {
  std::array<double, kNumServos> q{};
  q[10] = 0.55, q[11] = -0.55, q[12] = -1.06, q[13] = 1.06, q[14] = -0.60, q[15] = 0.60;
  return q;
}

/// Holds a pose by duty = stiffness x error, as a servo would.
void run(Plant& plant, const std::array<double, kNumServos>& q, double seconds) {
  for (int k = 0; k < seconds / kPhysicsStep_s; ++k) {
    for (int i = 0; i < kNumServos; ++i) plant.set_duty(i, 3.223 * (q[i] - plant.link_angle(i)));
    plant.step();
  }
}

TEST(Plant, MassIsTheSumOfTheMakersLinks) {
  EXPECT_NEAR(Plant(load_world("nominal")).mass_kg(), 3.14747, 1e-5);
  EXPECT_NEAR(Plant(load_world("lab")).mass_kg(), 3.14747 + 0.3, 1e-5);
}

TEST(Plant, ZeroPoseHasTheMakersHeightAndCentreOfMass) {
  Plant plant(load_world("nominal"));
  plant.place({}, 0, 0, 0);
  EXPECT_NEAR(plant.base().p_world_base[2], 0.2792, 5e-4);
  const Vec3 com = plant.center_of_mass() - plant.base().p_world_base;
  EXPECT_NEAR(com[0], -0.01057, 1e-4);
  EXPECT_NEAR(com[1], 0.00007, 1e-4);
  EXPECT_NEAR(com[2], -0.00484, 1e-4);
}

/// On a floor that leans and has plates, wherever the robot was put.
TEST(Plant, ASoleThatTouchesHasNoClearanceOnAnyFloor) {
  World world = load_world("nominal");
  world.ground.tilt_roll_rad = 0.015, world.ground.tilt_pitch_rad = -0.012;
  world.ground.plates = 150;
  Plant plant(world);
  double standing_lowest = 0.0, highest = 0.0;
  for (int place = 0; place < 12; ++place) {
    const double x = 0.13 * place - 0.7, y = 0.9 - 0.15 * place;
    plant.place(crouched(), x, y, 0.3 * place);
    for (int k = 0; k < 40; ++k) {
      run(plant, crouched(), 0.01);
      const auto feet = plant.feet();
      for (const FootLoad& foot : feet) {
        if (foot.contacts > 0) {
          EXPECT_LT(foot.clearance_m, 1e-9) << place;
        }
        standing_lowest = std::min(standing_lowest, foot.clearance_m);
        highest = std::max(highest, foot.clearance_m);
      }
    }
  }
  EXPECT_GT(standing_lowest, -0.006);  // no deeper than a plate's edge beside the sole
  EXPECT_GT(highest, 0.001);
}

TEST(Plant, FallsFreelyAndKeepsItsAngularMomentumWhileTheServosFight) {
  Plant plant(load_world("nominal"));
  plant.place(crouched(), 0, 0, 0);
  plant.set_push({0, 0, 400}, {0, 0, 0});  // throws it up
  run(plant, crouched(), 0.1);
  plant.set_push({0, 0, 0}, {0, 0, 0});
  run(plant, crouched(), 0.02);
  ASSERT_EQ(plant.feet()[0].contacts + plant.feet()[1].contacts, 0);
  const Vec3 p0 = plant.linear_momentum(), h0 = plant.angular_momentum();
  auto kick = crouched();
  kick[12] = -0.3;  // one knee kicks
  run(plant, kick, 0.2);
  const Vec3 p1 = plant.linear_momentum(), h1 = plant.angular_momentum();
  EXPECT_NEAR((p1[2] - p0[2]) / plant.mass_kg(), -9.81 * 0.2, 0.02);
  EXPECT_NEAR(p1[0] - p0[0], 0, 0.01);
  EXPECT_NEAR(p1[1] - p0[1], 0, 0.01);
  // rotors are bookkept outside MuJoCo: their share of the momentum is what may be missing
  EXPECT_NEAR(norm(h1 - h0), 0, 0.02);
}

TEST(Plant, StandsStillAndCarriesItsWeight) {
  Plant plant(load_world("lab"));
  plant.place(crouched(), 0, 0, 0);
  run(plant, crouched(), 2.0);
  const auto before = plant.base();
  run(plant, crouched(), 2.0);
  const auto after = plant.base();
  EXPECT_LT(norm(after.p_world_base - before.p_world_base), 1e-3);
  EXPECT_LT(norm(after.v_base_in_world), 1e-3);
  const auto feet = plant.feet();
  EXPECT_NEAR(feet[0].force_in_world[2] + feet[1].force_in_world[2], plant.mass_kg() * 9.81, 0.5);
  EXPECT_EQ(plant.other_contacts(), 0);
}

TEST(Plant, SymmetricPoseLoadsBothFeetAlike) {
  Plant plant(load_world("nominal"));
  plant.place(crouched(), 0, 0, 0);
  run(plant, crouched(), 2.0);
  const auto feet = plant.feet();
  // the torso's centre is 0.13 mm off
  EXPECT_NEAR(feet[0].force_in_world[2], feet[1].force_in_world[2], 0.8);
}

TEST(Plant, DroppedRobotComesToRest) {
  Plant plant(load_world("hard"));
  plant.place(crouched(), 0, 0, 0);
  for (int i = 0; i < kNumServos; ++i) plant.set_coast(i);
  for (int k = 0; k < 12000; ++k) plant.step();
  EXPECT_LT(norm(plant.base().v_base_in_world), 0.02);
  EXPECT_GT(plant.other_contacts(), 0);
  EXPECT_GT(plant.base().p_world_base[2], 0.01);  // not through the floor
}

TEST(Plant, FrictionForceStaysInsideTheWorldsCone) {
  const World world = load_world("hard");
  Plant plant(world);
  plant.place(crouched(), 0, 0, 0);
  run(plant, crouched(), 1.0);
  plant.set_push({12, 8, 0}, {0, 0, 0});
  for (int k = 0; k < 200; ++k) {
    run(plant, crouched(), 0.001);
    for (const FootLoad& foot : plant.feet()) {
      const auto& f = foot.force_in_world;
      EXPECT_GE(f[2], -1e-9);
      // pyramid's corner
      EXPECT_LE(std::hypot(f[0], f[1]), std::sqrt(2.0) * world.ground.friction * f[2] + 1e-6);
    }
  }
}

TEST(Plant, PutsTheFeetFlatWhateverTheTrunkDoes) {
  Plant plant(load_world("nominal"));
  auto q = crouched();
  q[10] += 0.3, q[11] -= 0.3;  // trunk leans
  plant.place(q, 0.5, -0.2, 1.0);
  run(plant, q, 0.01);
  EXPECT_EQ(plant.feet()[0].contacts, 8);
  EXPECT_EQ(plant.feet()[1].contacts, 8);
}

}  // namespace
}  // namespace sanso::plant
