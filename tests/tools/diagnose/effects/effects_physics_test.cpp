// Effects against what they should do: closed forms, or a brute-force integration written for the
// case.
#include <gtest/gtest.h>

#include <array>

#include "tests/support/small_world.h"
#include "tools/diagnose/effects/from_model.h"

namespace sanso::diagnose {
namespace {

using test::make_test_drive;
using test::whole;

SimParams with(const ModelFolder& model, std::string_view id, const std::vector<double>& theta) {
  SimParams params = make_params(model);
  find_effect(id)->apply(params, 0, theta);
  return params;
}

constexpr double kJ = 0.5 * 0.01 + 1e-6;  // of the test pendulum's load
constexpr double kMgl = 0.5 * 9.81 * 0.1;
constexpr double kStep = 1e-5;  // of the brute-force integrations

TEST(JointCompliance, IsTwoMassesAndASpring) {
  // J_m m'' = u - tau_s, J q'' = tau_s - mgl sin q, tau_s = k (m - q) + d (m' - q'), servo spring
  // on the link's encoder
  const double Jm = 0.01, k = 20, d = 0.05, kp = 5, kd = 0.1;
  const ModelFolder model = test::pendulum(
      "actuator = \"position_pd\"\nkp = 5\nkd = 0.1\narmature = 0.01\ntorque_limit = 0\n");
  const Drive drive = make_test_drive(model, 2.0, 0.002, [](int, double) { return 0.5; });
  for (const bool at_motor : {false, true}) {
    const auto out = simulate(with(model, "joint_compliance", {1 / k, d, at_motor ? 1.0 : 0.0}),
                              drive, std::vector{whole(drive, {0}, {0})});
    double q = 0, v = 0, m = 0, w = 0;
    std::size_t r = 0;
    for (int s = 0; r < drive.rows(); ++s) {
      const double t = s * kStep;
      if (t >= drive.t[r] - 1e-9) {
        ASSERT_NEAR(out[0].q[r], at_motor ? m : q, 1.5e-3)
            << "at " << t << " s, encoder at motor " << at_motor;  // h = 1 ms, resonance 70 rad/s
        ++r;
      }
      const double spring = k * (m - q) + d * (w - v);
      const double servo = kp * (0.5 - (at_motor ? m : q)) - kd * (at_motor ? w : v);
      w += kStep * (servo - spring) / Jm;
      v += kStep * (spring - kMgl * std::sin(q)) / kJ;
      m += kStep * w;
      q += kStep * v;
    }
  }
}

TEST(Backlash, LosesItsWidthAtReversal) {
  // no load: the link is carried by the flanks; behind a slow triangle of the motor it lags by half
  // the play on either side
  ModelFolder model = test::pendulum(
      "actuator = \"position_pd\"\nkp = 50\nkd = 1\narmature = 0.01\ntorque_limit = 0\nviscous = "
      "0\n");
  model.gravity = {0, 0, 0};
  const double width = 0.04;
  const Drive drive = make_test_drive(
      model, 8.0, 0.005, [](int, double t) { return t < 4 ? 0.1 * t : 0.8 - 0.1 * t; });
  SimParams params = with(model, "backlash", {width, 1});
  params.joints[0].air_drag = 2.0;  // the link does not fly through the gap by its own momentum
  SimParams seen_at_link = params;
  seen_at_link.joints[0].encoder_at_motor = false;
  const auto motor = simulate(params, drive, std::vector{whole(drive, {0}, {0})});
  // the motor follows the goal up to its velocity error kd/kp * 0.1
  EXPECT_NEAR(motor[0].q[600], 0.1 * 3 - 0.1 / 50, 4e-3);
  // where the encoder sits on the link, the servo moves the link to the goal, play or not, and the
  // motor runs ahead by half of it
  const auto link = simulate(seen_at_link, drive, std::vector{whole(drive, {0}, {0})});
  EXPECT_NEAR(link[0].q[600], 0.1 * 3 - 0.1 / 50, 4e-3);
}

TEST(Backlash, AHangingLoadSwingsFreeInsideThePlay) {
  // friction holds the motor at 0.02; the load may move 0.05 to either side and swings there with
  // its own period, undamped
  const ModelFolder model =
      test::pendulum("actuator = \"torque\"\narmature = 0.05\ncoulomb = 1.0\n");
  const Drive drive = make_test_drive(model, 3.0, 0.002, [](int, double) { return 0.0; });
  const auto out =
      simulate(with(model, "backlash", {0.1, 0}), drive, std::vector{whole(drive, {0.02}, {0})});
  const double w = std::sqrt(kMgl / kJ);
  for (std::size_t r = 0; r < drive.rows(); r += 25)
    EXPECT_NEAR(out[0].q[r], 0.02 * std::cos(w * drive.t[r]), 4e-4) << drive.t[r];
}

TEST(PreslidingFriction, IsTheLuGreModel) {
  // z' = v - |v| z / (c K), tau = z / c + s1 z'; driven by a torque that does not break away, then
  // does
  const double K = 0.1, c = 0.02, s1 = 0.05, Jm = 0.01;
  ModelFolder model = test::pendulum("actuator = \"torque\"\ntorque_limit = 0\narmature = 0.01\n");
  model.gravity = {0, 0, 0};
  const Drive drive = make_test_drive(
      model, 2.0, 0.002, [](int, double t) { return (t < 1 ? 0.06 : 0.2) * std::sin(8 * t); });
  std::vector<double> reference;  // q at every row, integrated with steps of kStep
  double q = 0, v = 0, z = 0;
  for (int s = 0; reference.size() < drive.rows(); ++s) {
    if (s * kStep >= drive.t[reference.size()] - 1e-9) reference.push_back(q);
    const double torque = drive.joints[0].command[reference.size() - 1];
    const double dz = v - std::abs(v) * z / (c * K);
    v += kStep * (torque - z / c - s1 * dz) / (kJ + Jm);
    z += kStep * dz;
    q += kStep * v;
  }
  ASSERT_GT(std::abs(q), 0.01);
  const auto worst_error = [&](double step) {
    const auto out = simulate(with(model, "presliding_friction", {K, c, s1}), drive,
                              std::vector{whole(drive, {0}, {0})}, {.max_step_s = step});
    double worst = 0.0;
    for (std::size_t r = 0; r < drive.rows(); ++r)
      worst = std::max(worst, std::abs(out[0].q[r] - reference[r]));
    return worst;
  };
  // the implicit bristle is of first order: about 1 % of the swing (0.25 rad), a quarter of that
  // with a quarter of the step
  const double coarse = worst_error(1e-3), fine = worst_error(2.5e-4);
  EXPECT_LT(coarse, 0.0125 * 0.25);
  EXPECT_LT(fine, 0.3 * coarse);
}

TEST(MaxwellSlip, HoldsBelowItsTorqueAndSlidesAbove) {
  ModelFolder model = test::pendulum("actuator = \"torque\"\ntorque_limit = 0\nviscous = 0.05\n");
  model.gravity = {0, 0, 0};
  const auto push = [&](double torque) {
    const Drive drive =
        make_test_drive(model, 3.0, 0.005, [torque](int, double) { return torque; });
    return simulate(with(model, "maxwell_slip_friction", {0.1, 20, 1}), drive,
                    std::vector{whole(drive, {0}, {0})})[0];
  };
  EXPECT_NEAR(push(0.009).q.back(), 0.009 / 20, 2e-5)
      << "all four springs stick: the first slides at a tenth of 0.1 N m times 20/5";
  EXPECT_LT(push(0.09).q.back(), 0.05);
  EXPECT_NEAR(push(0.2).dq.back(), (0.2 - 0.1) / 0.05, 1e-3);
}

TEST(FrictionAtRest, IsWhatTheFormulaGives) {
  // the largest torque that does not move the joint, found by bisection
  ModelFolder model = test::pendulum("actuator = \"torque\"\ntorque_limit = 0\ncoulomb = 0.1\n");
  model.gravity = {0, 0, 0};
  const auto breakaway = [&](const SimParams& params) {
    double low = 0, high = 2;
    for (int i = 0; i < 30; ++i) {
      const double torque = 0.5 * (low + high);
      const Drive drive =
          make_test_drive(model, 0.5, 0.005, [torque](int, double) { return torque; });
      (std::abs(simulate(params, drive, std::vector{whole(drive, {0}, {0})})[0].q.back()) < 1e-6
           ? low
           : high) = torque;
    }
    return low;
  };
  EXPECT_NEAR(breakaway(make_params(model)), 0.1, 1e-4);
  EXPECT_NEAR(breakaway(with(model, "coulomb_friction", {0.2})), 0.3, 1e-4);
  EXPECT_NEAR(breakaway(with(model, "stribeck_friction", {0.2, 0.1, 1})), 0.3, 1e-4);
  // t = 0.1 + 0.3 t
  EXPECT_NEAR(breakaway(with(model, "load_friction", {0.3})), 0.1 / (1 - 0.3), 1e-4);
  // no external torque
  EXPECT_NEAR(breakaway(with(model, "directional_load_friction", {0.3, 0.1})), 0.1 / 0.7, 1e-4);
  EXPECT_NEAR(breakaway(with(model, "gear_efficiency", {0.8})), 0.1 / 0.8, 1e-4);
  EXPECT_NEAR(breakaway(with(model, "asymmetric_friction", {0.03, 0})), 0.13, 1e-4);
  EXPECT_NEAR(breakaway(with(model, "position_friction", {0, 0.05, 3})), 0.15, 1e-4);
  EXPECT_NEAR(breakaway(with(model, "servo_deadband", {0.02})), 0.1, 1e-4)
      << "no torque limit, no full output: no dead zone";
}

TEST(AsymmetricFriction, IsItsMirrorTheOtherWayRound) {
  ModelFolder model = test::pendulum("actuator = \"passive\"\nviscous = 0.05\n");
  model.gravity = {0, 0, 0};
  const Drive drive = make_test_drive(model, 1.0, 0.01, [](int, double) { return 0.0; });
  const auto coasts = [&](double difference, double speed) {
    const SimParams params = with(model, "asymmetric_friction", {0.0, difference});
    return simulate(params, drive, std::vector{whole(drive, {0.0}, {speed})})[0].q.back();
  };
  EXPECT_LT(coasts(0.02, 1.0), 0.9 * coasts(-0.02, 1.0));
  EXPECT_DOUBLE_EQ(coasts(0.02, 1.0), -coasts(-0.02, -1.0));
  EXPECT_DOUBLE_EQ(coasts(-0.02, 1.0), -coasts(0.02, -1.0));
}

TEST(ServoProfile, IsATrapezoid) {
  ModelFolder model =
      test::pendulum("actuator = \"position_pd\"\nkp = 2000\nkd = 20\ntorque_limit = 0\n");
  model.gravity = {0, 0, 0};
  const Drive drive = make_test_drive(model, 2.0, 0.005, [](int, double) { return 1.0; });
  const auto out = simulate(with(model, "servo_profile", {1.0, 5.0}), drive,
                            std::vector{whole(drive, {0}, {0})});
  // 0.2 s up, 0.8 s cruise, 0.2 s down; behind by kd/kp * speed
  for (std::size_t r = 60; r < 180; ++r) EXPECT_NEAR(out[0].q[r], drive.t[r] - 0.1 - 0.01, 5e-3);
  EXPECT_NEAR(out[0].q.back(), 1.0, 2e-3);
}

TEST(CurrentLimit, IsAPlateauAndSupplySagLowersTheStall) {
  const ModelFolder model = test::pendulum("actuator = \"dc_servo\"\narmature = 0.01\n");
  const Drive drive =
      make_test_drive(model, 2.0, 0.005, [](int, double t) { return t < 1 ? 0.0 : 1.5; });
  const auto limited =
      simulate(with(model, "current_limit", {0.5}), drive, std::vector{whole(drive, {0}, {0})});
  double most = 0;
  for (double i : limited[0].i) most = std::max(most, std::abs(i));
  EXPECT_EQ(most, 0.5);
  // static: V = V0 - R_s |i duty|, i = duty V / R
  const Drive hold = make_test_drive(model, 3.0, 0.005, [](int, double) { return 1.5; });
  const auto sag =
      simulate(with(model, "supply_sag", {2.0}), hold, std::vector{whole(hold, {1.3}, {0})})[0];
  const double i = sag.i.back(), duty = sag.pwm.back();
  EXPECT_NEAR(sag.volt.back(), 12 - 2.0 * std::abs(i * duty), 1e-6);
  EXPECT_NEAR(1.78 * i, kMgl * std::sin(sag.q.back()), 1e-5);
}

TEST(LinkInertia, IsARotorToItsJointOnBothSidesOfNothing) {
  // a link with inertia of its own, so that it can lose some as well
  ModelFolder model = test::pendulum(
      "actuator = \"position_pd\"\nkp = 6\nkd = 0.1\n"
      "torque_limit = 0\narmature = 0.02\n");
  BodyInertia& body = model.tree.joints[0].body;
  body.about_com[0] = 0.004, body.about_com[4] = 0.003, body.about_com[8] = 0.001;
  const double about_joint = 0.5 * 0.01 + 0.003;
  const Effect& inertia = *find_effect("link_inertia");
  const double lowest = inertia.lowest(make_params(model), 0);
  EXPECT_NEAR(lowest, -0.9 * 0.003 / about_joint, 1e-9);
  const Drive drive =
      make_test_drive(model, 2.0, 0.005, [](int, double t) { return std::sin(9 * t); });
  const auto motion = [&](const char* id, double value) {
    return simulate(with(model, id, {value}), drive, std::vector{whole(drive, {0.1}, {0})})[0].q;
  };
  const auto nominal = motion("link_inertia", 0.0);
  for (const double share : {lowest, -0.1, -0.01, 0.01, 0.4, 1.0}) {
    const auto link = motion("link_inertia", share),
               rotor = motion("rotor_inertia", share * about_joint);
    double apart = 0.0, moved = 0.0;
    for (std::size_t k = 0; k < link.size(); ++k) {
      apart = std::max(apart, std::abs(link[k] - rotor[k]));
      moved = std::max(moved, std::abs(link[k] - nominal[k]));
    }
    EXPECT_LT(apart, 1e-9) << share;
    EXPECT_GT(moved, 1e-5) << share;
    const SimParams changed = with(model, "link_inertia", {share});
    for (const std::size_t k : {0u, 4u, 8u})
      EXPECT_GT(changed.tree.joints[0].body.about_com[k], 0.0) << share;
  }
  // beyond what it has nothing more is taken
  EXPECT_EQ(motion("link_inertia", lowest), motion("link_inertia", 2.0 * lowest));
}

TEST(EncoderOffset, MovesReadingsAndGravityTogether) {
  const ModelFolder model = test::pendulum(
      "actuator = \"position_pd\"\nkp = 3\nkd = 0.1\ntorque_limit = 0\narmature = 0.01\n");
  const Drive drive = make_test_drive(model, 4.0, 0.005, [](int, double) { return 0.8; });
  const auto out =
      simulate(with(model, "encoder_offset", {0.05}), drive, std::vector{whole(drive, {0.8}, {0})});
  EXPECT_EQ(out[0].q[0], 0.8) << "windows start where the encoder says";
  const double y = out[0].q.back();
  EXPECT_NEAR(3 * (0.8 - y), kMgl * std::sin(y - 0.05), 1e-5);
}

TEST(EncoderOffset, OfTheRecordAloneLeavesTheServoItsOwn) {
  const ModelFolder model = test::pendulum(
      "actuator = \"position_pd\"\nkp = 3\nkd = 0.1\ntorque_limit = 0\narmature = 0.01\n");
  const Drive drive = make_test_drive(model, 4.0, 0.005, [](int, double) { return 0.8; });
  const double y = simulate(with(model, "encoder_offset", {0.05, 1}), drive,
                            std::vector{whole(drive, {0.8}, {0})})[0]
                       .q.back();
  EXPECT_NEAR(3 * (0.8 - (y - 0.05)), kMgl * std::sin(y - 0.05), 1e-5);
}

TEST(Payload, ComesAtItsInstant) {
  const ModelFolder model = test::pendulum(
      "actuator = \"position_pd\"\nkp = 10\nkd = 0.5\ntorque_limit = 0\narmature = 0.01\n");
  const Drive drive = make_test_drive(model, 6.0, 0.005, [](int, double) { return 0.5; });
  const auto out = simulate(with(model, "payload", {0.5, 0, 0, -0.1, 3.0}), drive,
                            std::vector{whole(drive, {0.5}, {0})});
  EXPECT_NEAR(10 * (0.5 - out[0].q[595]), kMgl * std::sin(out[0].q[595]), 1e-4);
  EXPECT_NEAR(10 * (0.5 - out[0].q.back()), 2 * kMgl * std::sin(out[0].q.back()), 1e-4);
}

TEST(Tether, PullsWithItsForceTimesTheLever) {
  const ModelFolder model = test::pendulum(
      "actuator = \"position_pd\"\nkp = 10\nkd = 0.5\ntorque_limit = 0\narmature = 0.01\n");
  const Drive drive = make_test_drive(model, 3.0, 0.005, [](int, double) { return 0.0; });
  // 1 N along x at 0.1 m below the axis (axis +y: q > 0 moves the bob towards -x)
  const auto out =
      simulate(with(model, "tether", {1, 0, 0}), drive, std::vector{whole(drive, {0}, {0})});
  const double q = out[0].q.back();
  EXPECT_NEAR(10 * q, -0.1 * std::cos(q) - kMgl * std::sin(q), 1e-6);
}

TEST(LinkInertia, LeavesABodyItsShareOfItsOwn) {
  ModelFolder model = test::pendulum("actuator = \"passive\"\n");
  BodyInertia& body = model.tree.joints[0].body;
  body.about_com[0] = 0.004, body.about_com[4] = 0.003, body.about_com[8] = 0.001;
  const Effect& inertia = *find_effect("link_inertia");
  for (const double share : {0.05, 0.1, 0.4}) {
    SimulationSettings settings;
    settings.own_inertia = share;
    SimParams params = make_params(model, settings);
    const double lowest = inertia.lowest(params, 0);
    for (const double asked : {lowest, 3.0 * lowest}) {  // nobody takes more
      SimParams light = params;
      inertia.apply(light, 0, std::vector<double>{asked});
      for (const std::size_t k : {0U, 4U, 8U})
        EXPECT_NEAR(light.tree.joints[0].body.about_com[k], share * body.about_com[k], 1e-12);
    }
  }
}

}  // namespace
}  // namespace sanso::diagnose
