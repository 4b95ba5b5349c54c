// Identification at 10 ms: a robot of the model itself, with other servos and a delay, is found.
#include "host/learn/model/identify_fine.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/model/op3_step.h"

namespace sanso::learn {
namespace {

/// Standing with bent knees, its targets moved by sines; what is told holds `delay` ticks later.
Episode moved(const model::ModelParameters& robot, int delay) {
  const model::StepModel step_model = model::make_step_model(robot);
  const model::Ground ground = model::make_plane();
  model::Input rest = model::Input::Zero();
  rest << 0, 0, 0.5, -1.0, -0.5, 0, 0, 0, -0.5, 1.0, 0.5, 0;
  model::State x = model::neutral_state();
  x.segment<model::kNumJoints>(model::kXJoint) = rest;
  x[2] = 0.248;
  Episode episode;
  std::vector<model::Input> told;
  for (int k = 0; k < 400; ++k) {
    model::Input u = rest;
    for (int j = 0; j < model::kNumJoints; ++j)
      u[j] += 0.04 * std::sin(0.01 * k * (9.0 + 2.0 * (j % 6)) + (j < 6 ? 0.0 : 1.0));
    told.push_back(u);
    wire::Observation o;
    o.trial_tick = k;
    o.x = x;
    o.u_out = u;
    episode.ticks.push_back(o);
    const model::Input& holds = told[static_cast<std::size_t>(std::max(0, k - delay))];
    model::StepScratch scratch;
    model::State next;
    model::analytical_step(step_model, ground, x.data(), holds.data(), 0.01, 2, next.data(),
                           scratch);
    x = next;
  }
  return episode;
}

TEST(IdentifyFine, FindsServosAndDelay) {
  model::ModelParameters robot = model::nominal_parameters();
  for (model::ServoParameters& s : robot.servo) {
    s.stiffness *= 0.75;
    s.armature *= 0.8;
  }
  const auto windows = fine_windows_of(moved(robot, 2), 10, 3);
  ASSERT_GT(windows.size(), 50u);
  const FineIdentification found =
      identify_fine(windows, ParameterMap(model::nominal_parameters()), model::make_plane(), 1);
  EXPECT_LT(found.loss, 0.1 * found.loss_initial);
  EXPECT_NEAR(found.delay_s, 0.02, 0.003);
  EXPECT_NEAR(found.parameters.servo[3].stiffness / robot.servo[3].stiffness, 1.0, 0.1);
  // slow sines say little about a rotor: a delay that is a millisecond too short is one
  EXPECT_NEAR(found.parameters.servo[3].armature / robot.servo[3].armature, 1.0, 0.25);
}

TEST(IdentifyFine, LeavesGapsOut) {
  Episode episode = moved(model::nominal_parameters(), 1);
  const std::size_t whole = fine_windows_of(episode, 10, 1).size();
  episode.ticks.erase(episode.ticks.begin() + 200);
  // a window spans ten ticks and what was told in six before them
  EXPECT_EQ(fine_windows_of(episode, 10, 1).size(), whole - kFineSteps - kMostDelayTicks - 2);
  EXPECT_THROW(
      (void)identify_fine({}, ParameterMap(model::nominal_parameters()), model::make_plane(), 1),
      std::invalid_argument);
}

}  // namespace
}  // namespace sanso::learn
