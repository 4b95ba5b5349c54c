// Which recordings are followed in step. What they remember there is what they remember alone:
// effects_in_lanes_test.cpp, for every effect.
#include "tools/diagnose/sim/follow.h"

#include <gtest/gtest.h>

#include "tests/support/small_world.h"

namespace sanso::diagnose {
namespace {

/// Indices of recordings of three robots, the second and third changed by `change`, by group.
template <class Change>
std::vector<std::vector<std::size_t>> groups(const Change& change) {
  const ModelFolder model = test::arm("actuator = \"position_pd\"\nkp = 20\nkd = 1\n");
  const Drive drive = test::make_test_drive(model, 1.0, 0.01, [](int, double) { return 0.0; });
  const std::vector<Window> windows{test::whole_from_rest(drive)};
  std::vector<SimParams> robots(3, make_params(model));
  change(robots[1]);
  change(robots[2]);
  const MeasuredMotion motion;
  std::vector<Followed> all;
  all.reserve(robots.size());
  for (const SimParams& robot : robots) all.push_back({&robot, &drive, &motion, windows});
  return in_step(all);
}

TEST(Follow, RecordingsAreInStepWhereRobotsAreOneButForGainsAndBodies) {
  using Groups = std::vector<std::vector<std::size_t>>;
  const Groups one{{0, 1, 2}}, two{{0}, {1, 2}};
  EXPECT_EQ(groups([](SimParams&) {}), one);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[1].nominal.kp *= 2.0; }), one);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[1].p_scale = 2.0; }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[1].integral_rate = 0.5; }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.tree.joints[2].body.mass *= 1.1; }), one);
  EXPECT_EQ(groups([](SimParams& p) { p.late_payloads.push_back({2, {}, 0.5}); }), one);
  EXPECT_EQ(groups([](SimParams& p) { p.tree.joints[2].axis = {1, 0, 0}; }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.forces.push_back({1, {1, 0, 0}}); }), two);
  EXPECT_EQ(groups([](SimParams& p) { p.joints[0].derating = 0.01; }), (Groups{{0}, {1}, {2}}))
      << "temperatures are each recording's own";
}

/// A pendulum with bristles that swings for 4 s, and what they are at windows far apart.
std::vector<double> bristles(double recalled_s) {
  const ModelFolder model =
      test::pendulum("actuator = \"position_pd\"\nkp = 2\nkd = 0.1\ncoulomb = 0.1\n");
  const Drive drive =
      test::make_test_drive(model, 4.0, 0.01, [](int, double t) { return std::sin(5 * t); });
  SimParams params = make_params(model);
  params.joints[0].presliding_compliance = 0.2;
  params.joints[0].presliding_damping = 0.02;
  MeasuredMotion motion;
  motion.q.resize(1), motion.dq.resize(1);
  for (const double t : drive.t) {
    motion.q[0].push_back(0.3 * std::sin(5 * t));
    motion.dq[0].push_back(1.5 * std::cos(5 * t));
  }
  const std::vector<Window> windows{{130, 150, {}, {}}, {240, 260, {}, {}}, {330, 350, {}, {}}};
  Followed one{&params, &drive, &motion, windows};
  one.recalled_s = recalled_s;
  SimOptions options;
  options.max_step_s = 0.002;
  std::vector<double> out;
  const std::vector<std::vector<InnerStates>> followed = follow({&one, 1}, options);
  for (const InnerStates& at : followed.front()) out.push_back(at[0].bristle);
  return out;
}

TEST(Follow, WhatIsRecalledOfALongTimeIsAllOfIt) {
  const std::vector<double> all = bristles(kNone);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_NE(all[0], 0.0);
  EXPECT_EQ(bristles(100.0), all);
  EXPECT_EQ(bristles(4.0), all) << "the first window's beginning reaches the recording's";
  const std::vector<double> half = bristles(0.5), none = bristles(0.0);
  for (std::size_t w = 0; w < all.size(); ++w) {
    EXPECT_NEAR(half[w], all[w], 1e-3 * std::abs(all[w])) << "bristles forget";
    EXPECT_EQ(none[w], 0.0);
  }
}

/// Where the motor is, seen from a link that rests at `posture` with play of 0.02 rad; friction
/// holds the motor, whose servo asks for nothing.
double motor_behind(double posture) {
  const ModelFolder model =
      test::pendulum("actuator = \"position_pd\"\nkp = 2\nkd = 0.1\ncoulomb = 5\n");
  const Drive drive =
      test::make_test_drive(model, 1.0, 0.01, [posture](int, double) { return posture; });
  SimParams params = make_params(model);
  params.joints[0].backlash = 0.02;
  MeasuredMotion motion;
  motion.q.assign(1, std::vector<double>(drive.rows(), posture));
  motion.dq.assign(1, std::vector<double>(drive.rows(), 0.0));
  const std::vector<Window> windows{{50, 60, {}, {}}};
  const Followed one{&params, &drive, &motion, windows};
  SimOptions options;
  options.max_step_s = 0.002;
  return follow({&one, 1}, options).front().front()[0].motor_offset;
}

TEST(Follow, ALinkThatHangsAcrossItsPlayLeansOnTheMotor) {
  EXPECT_EQ(motor_behind(0.0), 0.0) << "straight down nothing presses it to either side";
  EXPECT_NEAR(std::abs(motor_behind(1.0)), 0.01, 1e-4);
  EXPECT_NEAR(motor_behind(1.0), -motor_behind(-1.0), 1e-9);
  EXPECT_GT(motor_behind(1.0), 0.0) << "held up against gravity, which turns it back";
}

/// Where the shoulder's motor is, seen from an arm that hangs still while its lower link is thrown
/// with `ddq` [rad/s^2]; play of 0.02 rad at the shoulder, whose friction holds the motor.
double motor_of_a_shoulder(double ddq) {
  const ModelFolder model =
      test::two_links("actuator = \"position_pd\"\nkp = 2\nkd = 0.1\ncoulomb = 5\n");
  const Drive drive = test::make_test_drive(model, 0.03, 0.01, [](int, double) { return 0.0; });
  SimParams params = make_params(model);
  params.joints[0].backlash = 0.02;
  MeasuredMotion motion;
  motion.q.assign(2, std::vector<double>(drive.rows(), 0.0));
  motion.dq = motion.q;
  for (std::size_t row = 0; row < drive.rows(); ++row) {
    motion.q[1][row] = 0.5 * ddq * drive.t[row] * drive.t[row];
    motion.dq[1][row] = ddq * drive.t[row];
  }
  const std::vector<Window> windows{{2, 3, {}, {}}};
  const Followed one{&params, &drive, &motion, windows};
  SimOptions options;
  options.max_step_s = 0.002;
  return follow({&one, 1}, options).front().front()[0].motor_offset;
}

TEST(Follow, ALinkThatOthersPushLeansOnTheMotor) {
  EXPECT_NEAR(motor_of_a_shoulder(100.0), 0.01, 1e-4) << "thrown forward, the arm must be held";
  EXPECT_NEAR(motor_of_a_shoulder(-100.0), -0.01, 1e-4);
  EXPECT_EQ(motor_of_a_shoulder(0.0), 0.0) << "straight down nothing presses it to either side";
}

}  // namespace
}  // namespace sanso::diagnose
