// The simulator against closed forms, our own second dynamics, and MuJoCo.
#include <gtest/gtest.h>
#include <algorithm>

#include <random>

#include "tests/oracle/tree.h"
#include "tests/support/small_world.h"
#include "tools/diagnose/sim/actuator.h"
#include "tools/diagnose/sim/tree_dynamics.h"

namespace sanso::diagnose {
namespace {

using test::make_test_drive;
using test::whole;

const auto kNoCommand = [](int, double) { return 0.0; };

TEST(Simulator, SmallSwingOfADampedPendulumIsTheClosedForm) {
  // J q'' + b q' + m g l q = 0; started at 1 mrad so that sin q = q to 2e-7
  const ModelFolder model =
      test::pendulum("actuator = \"passive\"\nviscous = 0.004\narmature = 0.001\n");
  const double J = 0.5 * 0.01 + 1e-6 + 0.001, b = 0.004, k = 0.5 * 9.81 * 0.1;
  const Drive drive = make_test_drive(model, 10.0, 0.01, kNoCommand);
  const auto out = simulate(make_params(model), drive, std::vector{whole(drive, {1e-3}, {0.0})});
  const double zeta = b / (2 * J), w = std::sqrt(k / J - zeta * zeta);
  for (std::size_t r = 0; r < drive.rows(); ++r) {
    const double t = drive.t[r];
    const double exact =
        1e-3 * std::exp(-zeta * t) * (std::cos(w * t) + zeta / w * std::sin(w * t));
    ASSERT_NEAR(out[0].q[r], exact, 2e-7)
        << "t = " << t;  // (h w)^2 t w / 24 with h = 1 ms, w = 9, t = 10 s: 2e-4 relative
  }
}

TEST(Simulator, MotorRunsUpLikeAnRcCircuit) {
  // J w' = kt/R (V - ke w): w = V/ke (1 - exp(-t/T)), T = J R / (kt ke)
  ModelFolder model = test::pendulum(
      "actuator = \"dc_servo\"\np_gain = 1e6\nvoltage = 12\nresistance = 5\ntorque_constant = "
      "1.5\nback_emf = 2\n"
      "torque_limit = 0\narmature = 0.02\n");
  model.gravity = {0, 0, 0};
  const Drive drive = make_test_drive(model, 1.0, 0.005, [](int, double) { return 1000.0; });
  const auto out = simulate(make_params(model), drive, std::vector{whole(drive, {0}, {0})});
  const double J = 0.005 + 1e-6 + 0.02, T = J * 5 / (1.5 * 2);
  for (std::size_t r = 0; r < drive.rows(); ++r) {
    const double t = drive.t[r];
    EXPECT_NEAR(out[0].dq[r], 6.0 * (1 - std::exp(-t / T)),
                1e-4);  // third order in h/T = 0.024: 2e-6 of 6, plus start-up
    EXPECT_NEAR(out[0].pwm[r], 1.0, 0);
  }
  EXPECT_NEAR(out[0].i.back(), 0.0, 1e-3);
}

TEST(Simulator, CoulombFrictionStopsAndHolds) {
  // constant deceleration K/J to an exact stop, then nothing moves although gravity pulls a little
  ModelFolder model = test::pendulum("actuator = \"passive\"\ncoulomb = 0.1\n");
  model.gravity = {0.5, 0, 0};  // 0.025 N m at q = 0: below the 0.1 N m that friction gives
  const Drive drive = make_test_drive(model, 1.0, 0.01, kNoCommand);
  model.gravity = {0, 0, 0};
  const auto free = simulate(make_params(model), drive, std::vector{whole(drive, {0}, {2.0})});
  const double J = 0.005 + 1e-6, deceleration = 0.1 / J, stop = 2.0 / deceleration;
  for (std::size_t r = 0; r < drive.rows(); ++r) {
    const double t = std::min(drive.t[r], stop);
    EXPECT_NEAR(free[0].q[r], 2.0 * t - 0.5 * deceleration * t * t, 2e-5) << drive.t[r];
  }
  EXPECT_EQ(free[0].dq.back(), 0.0);
  model.gravity = {0.5, 0, 0};
  const auto held = simulate(make_params(model), drive, std::vector{whole(drive, {0}, {0})});
  EXPECT_NEAR(held[0].q.back(), 0.0, 1e-15);
}

TEST(Simulator, DryFrictionThatCreepsLetsALoadedJointSink) {
  // below the creep speed w friction is K v / w: a pull of half of K sinks at w / 2; above it the
  // deceleration is that of dry friction
  ModelFolder model = test::pendulum("actuator = \"passive\"\ncoulomb = 0.1\n");
  const Drive drive = make_test_drive(model, 1.0, 0.01, kNoCommand);
  SimParams params = make_params(model);
  params.joints[0].creep_speed = 0.02;
  params.gravity = {0.5, 0, 0};  // m g l = 0.025 of 0.1 at most, pulling where the joint hangs to
  const auto sinks = simulate(params, drive, std::vector{whole(drive, {0.0}, {0.0})});
  const double pull = 0.5 * 0.5 * 0.1;
  EXPECT_NEAR(std::abs(sinks[0].dq.back()), 0.02 * pull / 0.1, 2e-5);
  params.gravity = {0, 0, 0};
  const auto free = simulate(params, drive, std::vector{whole(drive, {0.0}, {2.0})});
  const double deceleration = 0.1 / (0.005 + 1e-6);
  for (std::size_t r = 0; 2.0 - deceleration * drive.t[r] > 0.04; ++r)
    EXPECT_NEAR(free[0].dq[r], 2.0 - deceleration * drive.t[r], 1e-9) << drive.t[r];
  EXPECT_NEAR(free[0].dq.back(), 0.0, 1e-9);
}

TEST(Simulator, AnotherPGainOfARecordingLeavesTheIntegralGainAlone) {
  // registers of their own: duty = P error + I int(error), I = integral_rate times model.toml's P
  const auto duty = [](double p_gain) {
    ModelFolder model = test::pendulum("actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\n");
    recording::Recording changed;
    changed.overrides = {{"joint_default", "p_gain", {p_gain}, "", 0}};
    JointParams joint = make_params(with_overrides(model, changed)).joints[0];
    joint.integral_rate = 0.5, joint.feed_forward = 0.1;
    InnerState inner;
    ServoInput input{};
    input.command.value = 0.01, input.command.rate = 0.3, input.supply = 1.0, input.h = 1e-3;
    double last = 0.0;
    for (int k = 0; k < 1000; ++k) last = servo_step(joint, input, inner).duty;
    return last;
  };
  EXPECT_NEAR(duty(4.0), 4.0 * 0.01 + 4.0 * 0.5 * 0.01 + 4.0 * 0.1 * 0.3, 1e-9);
  EXPECT_NEAR(duty(4.0) - duty(2.0), 2.0 * 0.01, 1e-12);
}

TEST(Simulator, DampingOfTheErrorLetsAJointFollowFreely) {
  JointParams joint =
      make_params(test::pendulum("actuator = \"dc_servo\"\np_gain = 4.0\n")).joints[0];
  joint.d_torque = 0.4;
  ServoInput follows{};
  follows.command.rate = follows.velocity = 1.5, follows.supply = 1.0, follows.h = 1e-3;
  InnerState inner;
  const double brakes = servo_step(joint, follows, inner).duty;
  joint.d_on_error = 1.0;
  EXPECT_LT(brakes, -0.1);
  EXPECT_NEAR(servo_step(joint, follows, inner).duty, 0.0, 1e-15);
  follows.command.rate = 0.0;
  EXPECT_EQ(servo_step(joint, follows, inner).duty, brakes) << "a goal at rest: no difference";
}

TEST(Simulator, AnIntegralHoldsTheWeightWhereARecordingBegins) {
  // held for seconds before, the integral carries gravity alone: followed up to any window, the
  // joint stays where it is
  const ModelFolder model =
      test::pendulum("actuator = \"dc_servo\"\np_gain = 4.0\ni_gain = 40.0\narmature = 0.01\n");
  Drive drive = make_test_drive(model, 2.0, 0.01, [](int, double) { return 0.8; });
  MeasuredMotion motion;
  motion.q.assign(1, std::vector<double>(drive.rows(), 0.8));
  motion.dq.assign(1, std::vector<double>(drive.rows(), 0.0));
  SimOptions options;
  options.motion = &motion;
  const auto out = simulate(make_params(model), drive,
                            std::vector{Window{50, drive.rows() - 1, {0.8}, {0.0}}}, options);
  for (const double q : out[0].q) EXPECT_NEAR(q, 0.8, 2e-4);
}

TEST(Simulator, AnIntegralWindsUpAtFullOutputAsFarAsTheFirmwareLetsIt) {
  // 4 duty/rad one rad from the goal: limited throughout a second, in which the integral alone
  // would ask for 2
  const SimParams params = make_params(
      test::pendulum("actuator = \"dc_servo\"\np_gain = 4.0\ni_gain = 2.0\narmature = 0.01\n"));
  for (const auto& [windup, integral] : {std::pair{0.0, 0.0}, {0.5, 0.25}, {1e6, 1.0}}) {
    JointParams joint = params.joints[0];
    joint.windup = windup;
    InnerState inner;
    ServoInput input{};
    input.command.value = input.supply = 1.0;
    input.h = 1e-3;
    for (int k = 0; k < 1000; ++k) EXPECT_EQ(servo_step(joint, input, inner).duty, 1.0);
    EXPECT_NEAR(inner.integral, integral, 1.5e-3);
    input.command.value = -1.0;  // the other way it always may go
    servo_step(joint, input, inner);
    EXPECT_NEAR(inner.integral, integral - 1e-3, 1.5e-3);
  }
}

TEST(Simulator, StartSpeedIsThatOfTheLinkUnderANonlinearEncoder) {
  JointParams joint;
  joint.encoder_error = {0.03, 0.01, 1.0};
  joint.gear_error = {0.004, 0.002, 4.0};
  joint.encoder_scale = 0.02;
  const double q = 0.4, h = 1e-6;
  EXPECT_NEAR(encoder_slope(joint, q),
              (encoder_reading(joint, q + h) - encoder_reading(joint, q - h)) / (2 * h), 1e-9);
  EXPECT_NEAR(encoder_reading(joint, position_for_reading(joint, 0.5)), 0.5, 1e-9);
}

TEST(Simulator, ADelayOfTheSensorShowsWhatADelayOfTheCommandDoes) {
  // every signal a little later, whatever part of a step that is: commands jump every 10 ms, and
  // duty with them
  const ModelFolder model =
      test::pendulum("actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\n");
  const Drive drive =
      make_test_drive(model, 2.0, 0.01, [](int, double t) { return 0.5 * std::sin(5 * t); });
  SimOptions options;
  options.max_step_s = 2e-3;
  for (const double delay : {0.0044, 0.0206, 0.0293}) {
    SimParams command = make_params(model), sensor = command;
    command.joints[0].command_delay = sensor.joints[0].sensor_delay = delay;
    const std::vector windows{whole(drive, {0.0}, {0.0})};
    const auto a = simulate(command, drive, windows, options),
               b = simulate(sensor, drive, windows, options);
    for (std::size_t r = 10; r < drive.rows(); ++r) {
      ASSERT_NEAR(a[0].q[r], b[0].q[r], 1e-5) << delay << " at " << drive.t[r];
      // a jump is up to 0.1
      ASSERT_NEAR(a[0].pwm[r], b[0].pwm[r], 0.01) << delay << " at " << drive.t[r];
    }
  }
}

TEST(Simulator, ServoHoldsALoadWithTheDroopOfItsGain) {
  // static: kt V/R p (u - q) = m g l sin q
  const ModelFolder model = test::pendulum("actuator = \"dc_servo\"\narmature = 0.01\n");
  const Drive drive = make_test_drive(model, 3.0, 0.01, [](int, double) { return 1.0; });
  const auto out = simulate(make_params(model), drive, std::vector{whole(drive, {1}, {0})});
  const double q = out[0].q.back();
  EXPECT_NEAR(1.78 * 12 / 5.22 * 4.604 * (1.0 - q), 0.5 * 9.81 * 0.1 * std::sin(q), 1e-6);
}

TEST(Simulator, SwitchedOffServoCoasts) {
  // empty command: neither torque nor back-EMF, so a frictionless swing keeps its energy
  const ModelFolder model = test::pendulum("actuator = \"dc_servo\"\n");
  const Drive drive = make_test_drive(model, 5.0, 0.01, [](int, double) { return std::nan(""); });
  const auto out = simulate(make_params(model), drive, std::vector{whole(drive, {1.5}, {0})});
  const auto energy = [&](std::size_t r) {
    return 0.5 * (0.005 + 1e-6) * std::pow(out[0].dq[r], 2) -
           0.5 * 9.81 * 0.1 * std::cos(out[0].q[r]);
  };
  for (std::size_t r = 0; r < drive.rows(); ++r)
    EXPECT_NEAR(energy(r), energy(0), 2e-4 * 0.49) << r;
}

TEST(Simulator, CommandDelayShiftsTheResponseAndSensorDelayTheReading) {
  const auto command = [](int, double t) { return 0.5 * std::sin(3 * t); };
  ModelFolder model = test::pendulum("actuator = \"position_pd\"\nkp = 5\nkd = 0.1\n");
  model.gravity = {0, 0, 0};
  const Drive drive = make_test_drive(model, 4.0, 0.01, command);
  const Window start = whole(drive, {0}, {0});
  SimParams params = make_params(model);
  const auto nominal = simulate(params, drive, std::vector{start});
  params.joints[0].command_delay = 0.03;
  const auto late = simulate(params, drive, std::vector{start});
  params = make_params(model);
  params.joints[0].sensor_delay = 0.03;
  const auto old = simulate(params, drive, std::vector{start});
  for (std::size_t r = 203; r < drive.rows(); ++r) {
    EXPECT_NEAR(late[0].q[r], nominal[0].q[r - 3], 1e-6);  // both have settled into the same cycle
    // started 30 ms earlier, so the cycle is approached otherwise
    EXPECT_NEAR(old[0].q[r], nominal[0].q[r - 3], 2e-3);
  }
  params.joints[0].sensor_delay = 0.025;  // between samples: interpolated
  const auto between = simulate(params, drive, std::vector{start});
  EXPECT_NEAR(between[0].q[300], 0.5 * (nominal[0].q[297] + nominal[0].q[298]), 1e-3);
}

TEST(Simulator, WindowsAreIndependentOfEachOther) {
  const ModelFolder model =
      test::arm("actuator = \"position_pd\"\nkp = 20\nkd = 1\ncoulomb = 0.05\n");
  const Drive drive =
      make_test_drive(model, 2.0, 0.01, [](int j, double t) { return 0.2 * std::sin(2 * t + j); });
  const Window a{0, 100, {0, 0.1, 0}, {0, 0, 0}}, b{50, 120, {0.1, 0, 0}, {0.1, 0, 0}};
  const SimParams params = make_params(model);
  const auto together = simulate(params, drive, std::vector{a, b});
  EXPECT_EQ(together[0].q, simulate(params, drive, std::vector{a})[0].q);
  EXPECT_EQ(together[1].q, simulate(params, drive, std::vector{b})[0].q);
}

/// Two pendulums on one base.
constexpr const char* kTwoArms = R"(<robot name="two"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/></joint>
<link name="l1"><inertial><origin xyz="0 0 -0.1"/><mass value="0.5"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
<joint name="b" type="continuous"><parent link="l1"/><child link="l2"/><origin xyz="0 0 -0.2"/>
<axis xyz="1 0 0"/></joint>
<link name="l2"><inertial><origin xyz="0 0.02 -0.1"/><mass value="0.3"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
<joint name="c" type="continuous"><parent link="base"/><child link="r1"/><origin xyz="0 0.3 0"/>
<axis xyz="0 1 0"/></joint>
<link name="r1"><inertial><origin xyz="0 0 -0.1"/><mass value="0.5"/>
<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link></robot>)";

TEST(Simulator, OneBranchAloneIsTheSameBitForBit) {
  const ModelFolder model = parse_model(
      "format = 1\n[joint_default]\nactuator = \"dc_servo\"\ncoulomb = 0.05\narmature = 0.01\n"
      "i_gain = 0.5\n",
      kTwoArms, "two/model.toml");
  const Drive drive =
      make_test_drive(model, 1.0, 0.01, [](int j, double t) { return 0.3 * std::sin(4 * t + j); });
  MeasuredMotion motion;
  for (int j = 0; j < 3; ++j) motion.q.push_back(drive.joints[static_cast<std::size_t>(j)].command);
  motion.dq.assign(3, std::vector<double>(drive.rows(), 0.1));
  SimParams params = make_params(model);
  params.joints[1].backlash = 0.02;
  const std::vector<Window> windows{{0, 50, {0, 0.1, 0.2}, {0, 0, 0}},
                                    {40, 90, {0.1, 0, 0}, {0.1, 0, 0}}};
  SimOptions all, left;
  all.motion = left.motion = &motion;
  left.wanted = {0, 1, 0};
  const auto both = simulate(params, drive, windows, all),
             one = simulate(params, drive, windows, left);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    for (int j = 0; j < 2; ++j) {
      EXPECT_TRUE(std::ranges::equal(both[w].of(both[w].q, j), one[w].of(one[w].q, j)))
          << "joint " << j;
      EXPECT_TRUE(std::ranges::equal(both[w].of(both[w].i, j), one[w].of(one[w].i, j)))
          << "joint " << j;
    }
    EXPECT_TRUE(std::ranges::all_of(one[w].of(one[w].q, 2), [](double q) { return q == 0.0; }));
  }
  params.supply_resistance = 0.5;  // now the other arm's current matters
  EXPECT_EQ(simulate(params, drive, windows, all)[1].q,
            simulate(params, drive, windows, left)[1].q);
}

/// Gears are followed where one remembers, and left out where only servos do.
TEST(Simulator, WhatAServoRemembersDoesNotDependOnTheGearsOfAnotherBranch) {
  const ModelFolder model = parse_model(
      "format = 1\n[joint_default]\nactuator = \"dc_servo\"\ncoulomb = 0.05\narmature = 0.01\n"
      "i_gain = 0.5\n",
      kTwoArms, "two/model.toml");
  const Drive drive =
      make_test_drive(model, 1.0, 0.01, [](int j, double t) { return 0.3 * std::sin(4 * t + j); });
  MeasuredMotion motion;
  for (int j = 0; j < 3; ++j) motion.q.push_back(drive.joints[static_cast<std::size_t>(j)].command);
  motion.dq.assign(3, std::vector<double>(drive.rows(), 0.1));
  SimParams servos = make_params(model);
  servos.joints[2].output_filter = 0.01;
  servos.joints[2].profile_speed = 1.5;
  SimParams gears = servos;
  gears.joints[0].backlash = 0.02;
  const std::vector<Window> windows{{30, 60, {0, 0.1, 0.2}, {0, 0, 0}},
                                    {40, 90, {0.1, 0, 0}, {0.1, 0, 0}}};
  SimOptions options;
  options.motion = &motion;
  const auto a = simulate(servos, drive, windows, options),
             b = simulate(gears, drive, windows, options), c = simulate(servos, drive, windows);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    EXPECT_TRUE(std::ranges::equal(a[w].of(a[w].q, 2), b[w].of(b[w].q, 2)));
    EXPECT_TRUE(std::ranges::equal(a[w].of(a[w].pwm, 2), b[w].of(b[w].pwm, 2)));
    EXPECT_FALSE(std::ranges::equal(a[w].of(a[w].q, 0), b[w].of(b[w].q, 0)));
    EXPECT_FALSE(std::ranges::equal(a[w].of(a[w].q, 2), c[w].of(c[w].q, 2))) << "remembers";
  }
}

TEST(TreeDynamics, AgreesWithTheGeneralDynamicsOfTheController) {
  // two derivations: composite bodies about the base origin here, recursion in link frames there
  const ModelFolder model = test::arm("actuator = \"passive\"\n");
  model::Tree tree;
  tree.gravity = {0.3, -0.2, -9.7};
  for (const TreeJoint& joint : model.tree.joints) {
    model::TreeJoint t;
    t.parent = joint.parent;
    t.kind = joint.prismatic ? model::JointKind::prismatic : model::JointKind::revolute;
    t.R_parent_link0 =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(joint.R_parent_joint.data());
    t.p_parent_link0 = Eigen::Map<const Eigen::Vector3d>(joint.p_parent_joint.data());
    t.axis = Eigen::Map<const Eigen::Vector3d>(joint.axis.data());
    t.link.mass = joint.body.mass;
    t.link.com = Eigen::Map<const Eigen::Vector3d>(joint.body.com.data());
    t.link.about_com =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(joint.body.about_com.data());
    ASSERT_TRUE(tree.joints.try_push(t));
  }
  TreeDynamics ours(model.tree, {0.3, -0.2, -9.7});
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-2, 2);
  model::TreeScratch scratch;
  for (int trial = 0; trial < 50; ++trial) {
    model::TreeVector q(3), v(3), dv(3), tau(3);
    for (int j = 0; j < 3; ++j)
      q[j] = uniform(random), v[j] = uniform(random), dv[j] = uniform(random);
    JointMatrix M{};
    JointVector bias{}, inverse{};
    ours.set_positions(q.data());
    ours.mass_matrix(M);
    ours.bias(v.data(), bias);
    ours.inverse_dynamics(v.data(), dv.data(), inverse);
    model::TreeMatrix M_ref(3, 3);
    crba(tree, q, scratch, M_ref);
    rnea(tree, q, v, dv, scratch, tau);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(inverse[static_cast<std::size_t>(i)], tau[i], 1e-12) << "seed 7, trial " << trial;
      for (int j = 0; j <= i; ++j)
        EXPECT_NEAR(M[static_cast<std::size_t>(i * kMaxJoints + j)], M_ref(i, j), 1e-13);
    }
    rnea(tree, q, v, model::TreeVector::Zero(3), scratch, tau);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(bias[static_cast<std::size_t>(i)], tau[i], 1e-12);
  }
}

}  // namespace
}  // namespace sanso::diagnose
