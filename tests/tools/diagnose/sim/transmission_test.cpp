// Friction, springs, play and stops of one joint by what they must do in motion and at rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/small_world.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A motor of 0.02 kg m^2 on a lever without weight, driven by a torque.
struct Lever {
  explicit Lever(const std::string& settings = "") {
    model = pendulum("actuator = \"torque\"\ntorque_limit = 0\narmature = 0.02\n" + settings);
    model.gravity = {0, 0, 0};
    params = make_params(model);
  }
  JointParams& joint() { return params.joints[0]; }
  double inertia() const { return 0.5 * 0.01 + 1e-6 + 0.02; }
  Prediction run(const std::function<double(double)>& torque, double seconds, double q = 0.0,
                 double dq = 0.0) const {
    const Drive drive =
        make_test_drive(model, seconds, 0.005, [&](int, double t) { return torque(t); });
    return simulate(params, drive, std::vector{whole(drive, {q}, {dq})}).front();
  }
  ModelFolder model;
  SimParams params;
};

const auto kNothing = [](double) { return 0.0; };

TEST(Friction, HoldsWhateverItCanAndNotMore) {
  Lever lever("coulomb = 0.1\n");
  EXPECT_EQ(lever.run([](double) { return 0.099; }, 0.5).q.back(), 0.0);
  const double J = lever.inertia();
  EXPECT_NEAR(lever.run([](double) { return 0.15; }, 0.5).q.back(), 0.5 * 0.05 / J * 0.25, 1e-6);
  EXPECT_NEAR(lever.run([](double) { return -0.15; }, 0.5).q.back(), -0.5 * 0.05 / J * 0.25, 1e-6);
}

TEST(Friction, TheModelsAndTheEffectsPartAddUp) {
  Lever both("coulomb = 0.06\nviscous = 0.03\n"), one("coulomb = 0.1\nviscous = 0.05\n");
  both.joint().coulomb = 0.04, both.joint().viscous = 0.02;
  const auto torque = [](double t) { return 0.3 * std::sin(5 * t); };
  const Prediction a = both.run(torque, 1.0), b = one.run(torque, 1.0);
  for (std::size_t r = 0; r < a.rows; ++r) EXPECT_NEAR(a.q[r], b.q[r], 1e-12);
}

TEST(Friction, StribeckHoldsMoreThanItBrakes) {
  Lever lever("coulomb = 0.05\n");
  lever.joint().stribeck = 0.1, lever.joint().stribeck_speed = 0.05;
  EXPECT_EQ(lever.run([](double) { return 0.14; }, 0.3).q.back(), 0.0);
  // far above the Stribeck speed only the dry part brakes
  const Prediction fast = lever.run(kNothing, 0.2, 0.0, 3.0);
  EXPECT_NEAR(fast.dq.back(), 3.0 - 0.05 / lever.inertia() * 0.2, 1e-3);
}

TEST(Friction, OneDirectionMayRubMore) {
  Lever lever("coulomb = 0.1\n");
  lever.joint().coulomb_difference = 0.04;
  const double J = lever.inertia();
  EXPECT_NEAR(lever.run(kNothing, 0.1, 0.0, 2.0).dq.back(), 2.0 - 0.14 / J * 0.1, 1e-6);
  EXPECT_NEAR(lever.run(kNothing, 0.1, 0.0, -2.0).dq.back(), -2.0 + 0.06 / J * 0.1, 1e-6);
}

TEST(Friction, GrowsWithTheLoadItCarries) {
  Lever lever;
  lever.joint().load_friction = 0.2;
  const double J = lever.inertia();
  EXPECT_NEAR(lever.run([](double) { return 0.5; }, 0.2).dq.back(), 0.5 * 0.8 / J * 0.2, 1e-6);
  lever.joint().load_friction = 0.0, lever.joint().quadratic_load_friction = 0.2;
  EXPECT_NEAR(lever.run([](double) { return 0.5; }, 0.2).dq.back(), (0.5 - 0.05) / J * 0.2, 1e-6);
}

TEST(Friction, AnInefficientGearLosesItsShareWhenDriving) {
  Lever lever;
  lever.joint().efficiency = 0.7;
  EXPECT_NEAR(lever.run([](double) { return 0.5; }, 0.2).dq.back(),
              0.5 * 0.7 / lever.inertia() * 0.2, 1e-6);
}

TEST(Friction, PreslidingIsASpringUntilTheFrictionIsReached) {
  Lever lever("coulomb = 0.1\nviscous = 0.5\n");
  lever.joint().presliding_compliance = 0.05;
  // Dahl: torque F c (1 - exp(-x / (F compliance))) of a friction F, here 0.1
  const double bent = -0.1 * 0.05 * std::log(1.0 - 0.1);
  EXPECT_NEAR(lever.run([](double) { return 0.01; }, 4.0).q.back(), bent, 0.2 * bent);
  EXPECT_LT(lever.run([](double) { return 0.08; }, 4.0).q.back(), 0.02);
  EXPECT_GT(lever.run([](double) { return 0.15; }, 4.0).q.back(), 0.1);
}

TEST(Friction, DwellMakesAJointHarderToStart) {
  const auto moved = [](double wait) {
    Lever lever("coulomb = 0.05\n");
    lever.joint().dwell_rate = 0.5;
    const auto torque = [&](double t) { return t < wait ? 0.0 : 0.08; };
    return lever.run(torque, wait + 0.3).q.back();
  };
  EXPECT_GT(moved(0.05), 0.01);
  EXPECT_EQ(moved(3.0), 0.0);
}

TEST(AirDrag, SlowsAsTheSquareOfSpeed) {
  // v' = -c v^2 / J: v = v0 / (1 + c v0 t / J)
  Lever lever;
  lever.joint().air_drag = 0.01;
  const Prediction p = lever.run(kNothing, 1.0, 0.0, 5.0);
  EXPECT_NEAR(p.dq.back(), 5.0 / (1 + 0.01 * 5.0 / lever.inertia()), 2e-3);
}

TEST(Spring, PullsToItsOwnZeroAndSwingsAtItsFrequency) {
  Lever lever("viscous = 0.2\n");
  lever.joint().spring = 0.8, lever.joint().spring_torque = 0.16;
  EXPECT_NEAR(lever.run(kNothing, 6.0).q.back(), 0.2, 1e-6);
  Lever free;
  free.joint().spring = 0.8;
  const Prediction p = free.run(kNothing, 2.0, 0.1);
  const double w = std::sqrt(0.8 / free.inertia());
  EXPECT_NEAR(p.q.back(), 0.1 * std::cos(w * 2.0), 1e-4);
}

TEST(Stop, HoldsAtItsPlaceAndGivesByTorqueOverStiffness) {
  for (const double side : {1.0, -1.0}) {
    Lever lever("viscous = 0.3\n");
    lever.joint().stop_stiffness = 40.0;
    lever.joint().stop_position = 0.3 * side, lever.joint().stop_side = side;
    const Prediction p = lever.run([&](double) { return 0.4 * side; }, 4.0);
    EXPECT_NEAR(p.q.back(), side * (0.3 + 0.4 / 40.0), 1e-4);
    const Prediction away = lever.run([&](double) { return -0.4 * side; }, 1.0);
    EXPECT_GT(std::abs(away.q.back()), 0.35) << "the other side is free";
  }
}

TEST(Stop, SwallowsWhatItIsToldTo) {
  const auto rebound = [](double loss) {
    Lever lever;
    lever.joint().stop_stiffness = 100.0, lever.joint().stop_position = 0.1;
    lever.joint().stop_loss = loss;
    return -lever.run(kNothing, 0.4, 0.0, 1.0).dq.back();
  };
  EXPECT_NEAR(rebound(0.0), 1.0, 0.02);
  // half a period of a damped swing; the damping counts the link's inertia, the swing the rotor too
  const double damping = 0.5 * std::sqrt(100.0 * (0.005 + 1e-6));
  const double zeta = damping / (2.0 * std::sqrt(100.0 * Lever().inertia()));
  EXPECT_NEAR(rebound(0.5), std::exp(-M_PI * zeta / std::sqrt(1 - zeta * zeta)), 0.02);
}

TEST(Cogging, HasDetentsWhereItsTorqueIsZero) {
  Lever lever("viscous = 0.1\n");
  lever.joint().cogging = {-0.05, 0.0, 6.0};  // stable at 0, 2 pi / 6, ...
  for (const double start : {0.3, 1.2, -0.9}) {
    const double turns = lever.run(kNothing, 8.0, start).q.back() * 6.0 / (2 * M_PI);
    EXPECT_NEAR(turns, std::round(turns), 1e-3) << start;
  }
}

TEST(Compliance, TwistsByTorqueTimesCompliance) {
  // the link hangs on a spring to the world: both sides of the gear stand where statics says
  Lever lever("viscous = 0.3\n");
  lever.joint().spring = 2.0;
  lever.joint().compliance = 0.2, lever.joint().compliance_damping = 0.05;
  const auto torque = [](double) { return 0.3; };
  EXPECT_NEAR(lever.run(torque, 8.0).q.back(), 0.3 / 2.0, 1e-4);
  lever.joint().encoder_at_motor = true;
  EXPECT_NEAR(lever.run(torque, 8.0).q.back(), 0.3 / 2.0 + 0.3 * 0.2, 1e-4);
}

TEST(Backlash, LetsTheLinkFallThroughThePlayAndNoFarther) {
  ModelFolder model = pendulum(
      "actuator = \"position_pd\"\nkp = 400\nkd = 4\ntorque_limit = 0\n"
      "armature = 0.02\n");
  SimParams params = make_params(model);
  params.joints[0].backlash = 0.06, params.joints[0].encoder_at_motor = true;
  for (const double side : {1.0, -1.0}) {
    const Drive drive = make_test_drive(model, 3.0, 0.01, [&](int, double) { return 0.5 * side; });
    const Prediction p =
        simulate(params, drive, std::vector{whole(drive, {0.5 * side}, {0})}).front();
    EXPECT_NEAR(p.q.back(), 0.5 * side, 3e-3) << "the motor is where it should be";
    const double held = 0.5 * 9.81 * 0.1 * std::sin((0.5 - 0.03) * 1.0);
    EXPECT_NEAR(std::abs(p.tau.back()), held, 2e-3) << "the link hangs half the play lower";
  }
}

TEST(Armature, IsInertiaOfTheMotorAlone) {
  Lever lever, heavier;
  heavier.joint().armature = 0.025;
  const auto torque = [](double) { return 0.2; };
  const double light = lever.run(torque, 0.3).dq.back(), heavy = heavier.run(torque, 0.3).dq.back();
  EXPECT_NEAR(light / heavy, (lever.inertia() + 0.025) / lever.inertia(), 1e-9);
}

TEST(Replay, ExplainsTheMotionThatTheSimulatorMade) {
  // motor + friction + passive = M ddq + bias along the simulated motion
  Lever lever("viscous = 0.05\ncoulomb = 0.03\n");
  lever.joint().spring = 0.3;
  const auto torque = [](double t) { return 0.3 * std::sin(4 * t); };
  const Prediction p = lever.run(torque, 2.0);
  const Drive drive =
      make_test_drive(lever.model, 2.0, 0.005, [&](int, double t) { return torque(t); });
  const MeasuredMotion motion{{p.q}, {p.dq}};
  const ReplayTorques replay = replay_torques({{{&lever.params, &drive, &motion}}}).front();
  int compared = 0;
  for (std::size_t r = 1; r + 1 < p.rows; ++r) {
    if (std::min(std::abs(p.dq[r - 1]), std::abs(p.dq[r])) < 0.05) continue;
    // what is replayed at a row is the mean over the step before it
    const double ddq = (p.dq[r] - p.dq[r - 1]) / 0.005;
    EXPECT_NEAR(replay.motor[r] + replay.friction[r] + replay.passive[r], lever.inertia() * ddq,
                0.012)
        << r;
    ++compared;
  }
  EXPECT_GT(compared, 200);
}

}  // namespace
}  // namespace sanso::diagnose
