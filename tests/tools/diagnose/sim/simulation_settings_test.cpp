// What a simulation takes for granted: each setting does what it says, against the same said
// another way.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/small_world.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/sim/actuator.h"
#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {
namespace {

const char* const kServo =
    "actuator = \"dc_servo\"\np_gain = 3\nvoltage = 12\nresistance = 5\ntorque_constant = 1.5\n"
    "back_emf = 1.5\ntorque_limit = 0\ncoulomb = 0.02\n";

std::vector<double> swing(const SimParams& params, const ModelFolder& model) {
  const Drive drive =
      test::make_test_drive(model, 2.0, 0.01, [](int, double t) { return std::sin(7 * t); });
  return simulate(params, drive, std::vector{test::whole(drive, {0.1}, {0.0})}).front().q;
}

double farthest(const std::vector<double>& a, const std::vector<double>& b) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

TEST(SimulationSettings, AreThoseThatAModelIsSimulatedWith) {
  SimulationSettings settings;
  settings.held = 7.0;
  const ModelFolder model = test::pendulum(kServo);
  EXPECT_EQ(make_params(model, settings).settings.held, 7.0);
  EXPECT_EQ(params_with_effects(model, settings).settings.held, 7.0);
}

TEST(SimulationSettings, AnIntegralGrowsTowardsWhatHoldsForEver) {
  JointParams joint =
      make_params(test::pendulum("actuator = \"position_pd\"\nkp = 20\nkd = 0.5\n")).joints[0];
  joint.integral_rate = 0.4;
  const auto integral = [&](double seconds) { return settled_integral(joint, 1.5, 1.0, seconds); };
  const double whole = integral(1e6);
  EXPECT_NEAR(0.4 * 20.0 * whole, 1.5, 1e-12) << "carries the torque alone";
  for (const double seconds : {1.5, 3.0, 6.0})
    EXPECT_NEAR(1.0 - integral(seconds) / whole, std::exp(-0.4 * seconds), 1e-12);
}

TEST(SimulationSettings, AShareOfTheLinkIsAMotorWithoutInertiaOfItsOwn) {
  const ModelFolder model = test::pendulum(kServo);
  SimParams none = make_params(model);
  none.joints[0].compliance = 0.02, none.joints[0].compliance_damping = 0.05;
  none.joints[0].nominal.armature = 0.0;
  SimParams share = none, stated = none;
  share.settings.motor_share *= 2.0;
  stated.joints[0].nominal.armature = share.settings.motor_share * (0.5 * 0.01 + 1e-6);
  EXPECT_LT(farthest(swing(share, model), swing(stated, model)), 1e-9);
  EXPECT_GT(farthest(swing(share, model), swing(none, model)), 1e-7);
}

TEST(SimulationSettings, AWindingThatHeatsTwiceAsMuchIsOneThatSuffersTwiceAsMuch) {
  const ModelFolder model = test::pendulum(kServo);
  SimParams cold = make_params(model), hot = cold, weak = cold;
  cold.joints[0].derating = hot.joints[0].derating = 0.02;
  hot.settings.thermal_resistance *= 2.0;
  weak.joints[0].derating = 0.04;
  EXPECT_LT(farthest(swing(hot, model), swing(weak, model)), 1e-12);
  EXPECT_GT(farthest(swing(hot, model), swing(cold, model)), 1e-9);
  SimParams slow = cold;
  slow.settings.thermal_time *= 1000.0;
  EXPECT_LT(farthest(swing(slow, model), swing(make_params(model), model)),
            farthest(swing(cold, model), swing(make_params(model), model)));
}

TEST(SimulationSettings, OneSweepIsEnoughForOneJoint) {
  const ModelFolder model = test::pendulum(kServo);
  SimParams one = make_params(model);
  const std::vector<double> many = swing(one, model);
  one.settings.friction_sweeps = 1, one.settings.friction_settled *= 1000.0;
  EXPECT_EQ(swing(one, model), many);
}

}  // namespace
}  // namespace sanso::diagnose
