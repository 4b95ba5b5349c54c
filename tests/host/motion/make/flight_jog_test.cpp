// A jog that flies: laws of its kinematics, what the model makes of it, and its file.
#include "host/motion/make/flight_jog.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "host/motion/catalogue.h"
#include "host/motion/dmp_fit.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/rehearse.h"

namespace sanso::motion {
namespace {

const FlightReference& reference() {
  static const FlightReference made = flight_reference({});
  return made;
}

const Rehearsal& rehearsed() {
  static const Rehearsal made =
      rehearse(reference(), model::make_step_model(model::nominal_parameters()));
  return made;
}

double lowest_point(const model::State& x, int side) {
  const auto corners = body_points(x).sole_corners(side);
  return std::min({corners[0].z(), corners[1].z(), corners[2].z(), corners[3].z()});
}

// Per step that could have a flight.
double in_the_air_s(const Rehearsal& r) {
  return std::accumulate(r.flights_s.begin(), r.flights_s.end(), 0.0) / r.steps;
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
  const Rehearsal& r = rehearsed();
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

// Which steps fly for 20 ms hangs on the last digit of a contact; time in the air, over two jogs
// next to each other, does not (16 to 21 ms a step, 0 to 3 with the heavy rotors).
TEST(Rehearsal, FliesInTheModelAndSoftServosFlyLess) {
  model::ModelParameters soft = model::nominal_parameters();
  for (model::ServoParameters& s : soft.servo) s.armature *= 2.0;
  double light_s = 0.0, heavy_s = 0.0, light_worth = 0.0, heavy_worth = 0.0;
  constexpr std::array kLiftOff_m_s = {0.235, 0.245};
  for (const double lift_off : kLiftOff_m_s) {
    FlightJog figures;
    figures.steps = 8;
    figures.lift_off_m_s = lift_off;
    const FlightReference jog = flight_reference(figures);
    const Rehearsal light = rehearse(jog, model::make_step_model(model::nominal_parameters()));
    const Rehearsal heavy = rehearse(jog, model::make_step_model(soft));
    EXPECT_TRUE(light.upright && heavy.upright) << lift_off;
    light_s += in_the_air_s(light) / kLiftOff_m_s.size();
    heavy_s += in_the_air_s(heavy) / kLiftOff_m_s.size();
    light_worth += worth(light);
    heavy_worth += worth(heavy);
  }
  EXPECT_GT(light_s, 0.010);
  EXPECT_LT(heavy_s, 0.5 * light_s);
  EXPECT_GT(light_worth, heavy_worth);
}

TEST(Rehearsal, ItsMotionReadsBackAndWaivesNothing) {
  const Rehearsal& r = rehearsed();
  const Motion m = jog_motion("jog_fly", {}, reference(), r);
  const Motion back = parse_motion(to_toml(m), "again");
  ASSERT_TRUE(back.flight && back.target_rate_rad_s);
  EXPECT_EQ(back.flight->heel_rad, FlightJog{}.heel_rad);
  EXPECT_EQ(*back.target_rate_rad_s, RehearsalSettings{}.target_rate_rad_s);
  EXPECT_EQ(to_toml(back), to_toml(m));
  // what was rehearsed is told: the planner of a trial adds less to it than to other motions
  EXPECT_GT(back.weights.input.minCoeff(), catalogue_entry("jog").weights.input.maxCoeff());
  for (const Clause& clause : back.success) EXPECT_TRUE(clause.waived.empty()) << clause.measure;
}

}  // namespace
}  // namespace sanso::motion
