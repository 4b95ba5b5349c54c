// A jog that flies: laws of its kinematics, what the model makes of it, and its file.
#include "host/motion/make/flight_jog.h"

#include <gtest/gtest.h>

#include "host/motion/dmp_fit.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/rehearse.h"

namespace sanso::motion {
namespace {

const FlightReference& reference() {
  static const FlightReference made = flight_reference({});
  return made;
}

double lowest_point(const model::State& x, int side) {
  const auto corners = body_points(x).sole_corners(side);
  return std::min({corners[0].z(), corners[1].z(), corners[2].z(), corners[3].z()});
}

TEST(FlightJog, EveryStepLeavesTheGroundForTheFlight) {
  const FlightReference& r = reference();
  for (std::size_t i = 1; i < r.plan.swings.size(); ++i) {
    const double up = r.plan.swings[i].lift_s, down = r.plan.swings[i - 1].land_s;
    EXPECT_NEAR(down - up, FlightJog{}.flight_s, 1e-12);
    const double middle = 0.5 * (up + down);
    EXPECT_FALSE(r.plan.carries(kRight, middle) || r.plan.carries(kLeft, middle));
  }
}

TEST(FlightJog, AFootThatCarriesTouchesTheGroundAndNoMore) {
  const FlightReference& r = reference();
  for (std::size_t k = 0; k < r.body.trajectory.x.size(); ++k)
    for (const int side : {kRight, kLeft}) {
      if (!r.body.target.carries[k][static_cast<std::size_t>(side)]) continue;
      EXPECT_NEAR(lowest_point(r.body.trajectory.x[k], side), 0.0, 1e-4)
          << "tick " << k << ", heel up or not";
    }
}

TEST(FlightJog, AStepGainsNoHeightAndTheThrowIsFree) {
  const FlightReference& r = reference();
  const FlightJog f;
  const auto height = [&](double t) {
    return r.body.trajectory.x[static_cast<std::size_t>(std::lround(100.0 * t))][2];
  };
  const double first = r.plan.swings[2].lift_s, period = 5.0 * f.period_s;
  EXPECT_NEAR(height(first), height(first + period), 0.003);  // 0.24 m/s for half a tick
  const double fall = height(first) + f.lift_off_m_s * 0.04 - 0.5 * 9.81 * 0.04 * 0.04;
  EXPECT_NEAR(height(first + 0.04), fall, 0.003);
}

TEST(FlightJog, WithoutAStanceItIsRefused) {
  FlightJog f;
  f.flight_s = f.period_s;
  EXPECT_THROW((void)flight_reference(f), ClipError);
}

TEST(Rehearsal, TellsWhatTheServosNeedToHoldTheRobot) {
  const Rehearsal r = rehearse(reference(), model::make_step_model(model::nominal_parameters()));
  ASSERT_TRUE(r.upright);
  // settled at the end: the targets are off the joints by what the weight bends the servos
  const model::State& told = r.told.x.back();
  const model::State& wanted = reference().body.trajectory.x.back();
  double most = 0.0;
  for (int j = 0; j < model::kNumJoints; ++j)
    most = std::max(most, std::abs(told[model::kXJoint + j] - wanted[model::kXJoint + j]));
  EXPECT_GT(most, 0.03);  // half the weight, 65 mm beside a knee: 1.1 N m over 13.2 N m/rad
  EXPECT_LT(most, 0.20);
}

TEST(Rehearsal, FliesInTheModelAndSoftServosFlyLess) {
  model::ModelParameters soft = model::nominal_parameters();
  for (model::ServoParameters& s : soft.servo) s.armature *= 2.0;
  const Rehearsal light =
      rehearse(reference(), model::make_step_model(model::nominal_parameters()));
  const Rehearsal heavy = rehearse(reference(), model::make_step_model(soft));
  EXPECT_GE(light.flight_share(0.02), 0.5);
  EXPECT_LT(heavy.flight_share(0.02), light.flight_share(0.02));
  EXPECT_GT(worth(light), worth(heavy));
}

TEST(Rehearsal, ItsMotionReadsBackAndWaivesNothing) {
  const Rehearsal r = rehearse(reference(), model::make_step_model(model::nominal_parameters()));
  const Motion m = jog_motion("jog_fly", {}, reference(), r);
  const Motion back = parse_motion(to_toml(m), "again");
  ASSERT_TRUE(back.flight && back.target_rate_rad_s);
  EXPECT_EQ(back.flight->heel_rad, FlightJog{}.heel_rad);
  EXPECT_EQ(*back.target_rate_rad_s, RehearsalSettings{}.target_rate_rad_s);
  EXPECT_EQ(to_toml(back), to_toml(m));
  for (const Clause& clause : back.success) EXPECT_TRUE(clause.waived.empty()) << clause.measure;
}

}  // namespace
}  // namespace sanso::motion
