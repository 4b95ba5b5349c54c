// The gear train alone: play, stiction, spring, energy.
#include "tools/plant/gear_train.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sanso::plant {
namespace {

constexpr double kStep = 0.0005;

GearTrainParameters frictionless() {
  return {5.217, 1.783, 2.491, 0.027, 1500, 1.2, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0};
}

TEST(GearTrain, FreePlayPassesNoTorque) {
  auto p = frictionless();
  p.backlash_rad = 0.02;
  GearTrain gear;
  gear.place(0);
  gear.step(p, kStep, true, 3.0, 0.0, 0.0);
  EXPECT_GT(gear.angle_rad, 0);
  EXPECT_EQ(gear.gear_torque_Nm, 0);
  for (int k = 0; k < 2000; ++k) gear.step(p, kStep, true, 3.0, 0.0, 0.0);
  EXPECT_GT(gear.angle_rad, 0.01);  // against the far flank
  EXPECT_NEAR(gear.gear_torque_Nm, 1.783 * 3.0 / 5.217, 0.01);
}

TEST(GearTrain, LinkLosesMotionOfTheWidthOfThePlay) {
  auto p = frictionless();
  p.backlash_rad = 0.02;
  GearTrain gear;
  gear.place(0);
  for (int k = 0; k < 4000; ++k) gear.step(p, kStep, true, 1.0, 0.0, 0.0);
  const double one_side = gear.angle_rad;
  for (int k = 0; k < 4000; ++k) gear.step(p, kStep, true, -1.0, 0.0, 0.0);
  const double windup = 2 * (1.783 * 1.0 / 5.217) / p.stiffness_Nm_rad;
  EXPECT_NEAR(one_side - gear.angle_rad, 0.02 + windup, 1e-4);
}

TEST(GearTrain, StictionHoldsExactlyUntilTheBreakaway) {
  auto p = frictionless();
  p.coulomb_Nm = 0.10;
  p.stribeck_extra_Nm = 0.05;
  p.stiffness_Nm_rad = 0;
  p.damping_Nms_rad = 0;
  const double volt_per_Nm = 5.217 / 1.783;
  GearTrain gear;
  for (int k = 0; k < 1000; ++k) gear.step(p, kStep, true, 0.149 * volt_per_Nm, 0, 0);
  EXPECT_EQ(gear.rate_rad_s, 0.0);
  EXPECT_EQ(gear.angle_rad, 0.0);
  for (int k = 0; k < 1000; ++k) gear.step(p, kStep, true, 0.16 * volt_per_Nm, 0, 0);
  EXPECT_GT(gear.rate_rad_s, 0.0);
}

TEST(GearTrain, LoadFrictionGrowsWithTheTransmittedTorque) {
  auto p = frictionless();
  p.load_friction = 0.2;
  // raising against a locked link and easing off leave different torques: hysteresis of 2 x 20 %
  GearTrain gear;
  double torque = 0;
  const auto ramp_to = [&](double target) {  // slowly: no overshoot
    while (std::abs(target - torque) > 1e-9) {
      torque += std::clamp(target - torque, -2e-4, 2e-4);
      gear.step(p, kStep, true, torque * 5.217 / 1.783, 0, 0);
    }
    return gear.gear_torque_Nm;
  };
  const double rising = ramp_to(2.0);
  ramp_to(3.0);
  const double falling = ramp_to(2.0);
  EXPECT_NEAR(rising, 2.0 / 1.2, 0.05);
  EXPECT_NEAR(falling, std::min(3.0 / 1.2, 2.0 / 0.8), 0.05);
}

TEST(GearTrain, OpenBridgeNeitherDrivesNorBrakes) {
  auto p = frictionless();
  p.stiffness_Nm_rad = p.damping_Nms_rad = 0;
  GearTrain gear;
  gear.rate_rad_s = 2.0;
  for (int k = 0; k < 1000; ++k) gear.step(p, kStep, false, 12.0, 0, 0);
  EXPECT_DOUBLE_EQ(gear.rate_rad_s, 2.0);
  EXPECT_EQ(gear.current_A, 0.0);
  gear.step(p, kStep, true, 0.0, 0, 0);  // shorted: back-EMF brakes
  EXPECT_LT(gear.rate_rad_s, 2.0);
}

TEST(GearTrain, ElasticEnergyNeverGrowsByItself) {
  auto p = frictionless();
  p.backlash_rad = 0.01;
  // motor and a free link of 0.003 kg m^2, thrown against each other
  GearTrain gear;
  gear.rate_rad_s = 3.0;
  double link = 0, link_rate = -2.0;
  double last = 1e9;
  for (int k = 0; k < 20000; ++k) {
    gear.step(p, kStep, false, 0, link, link_rate);
    link_rate += kStep * gear.gear_torque_Nm / 0.003;
    link += kStep * link_rate;
    if (k % 1000 == 999) {
      const double gap = gear.angle_rad - link;
      const double stretch = std::max(0.0, std::abs(gap) - 0.005);
      const double energy = 0.5 * p.motor_inertia_kgm2 * gear.rate_rad_s * gear.rate_rad_s +
                            0.5 * 0.003 * link_rate * link_rate +
                            0.5 * p.stiffness_Nm_rad * stretch * stretch;
      EXPECT_LE(energy, last * (1 + 1e-4));  // the link side is integrated explicitly
      last = energy;
    }
  }
}

}  // namespace
}  // namespace sanso::plant
