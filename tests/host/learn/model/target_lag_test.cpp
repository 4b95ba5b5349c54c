// Targets that act later than they were sent: what a window says of them, and the network's inputs.
#include <gtest/gtest.h>

#include "tests/host/learn/model/learner_world.h"

namespace sanso::learn {
namespace {

/// An episode whose targets are c + slope t + bend t^2, rad, t in ticks.
Episode with_targets(double slope, double bend) {
  Episode e = episode_of_world(0);
  for (wire::Observation& o : e.ticks)
    o.u_out.setConstant(0.1 + slope * o.trial_tick + bend * o.trial_tick * o.trial_tick);
  return e;
}

/// Their mean over the step that begins at `tick`, each as it was `lag` ticks before.
double mean_before(double slope, double bend, int tick, double lag) {
  double sum = 0.0;
  for (int k = 0; k < kTicksPerStep; ++k) {
    const double t = tick + k - lag;
    sum += (0.1 + slope * t + bend * t * t) / kTicksPerStep;
  }
  return sum;
}

TEST(TargetLag, AWindowHasTheTargetsThatActInItsSteps) {
  const auto windows = windows_of(with_targets(0.003, 0.0));
  for (const double lag : {0.0, 1.0, 2.5, 4.0})
    for (std::size_t w = 1; w < 4; ++w)
      for (int k = 0; k < kPredictionSteps; ++k) {
        const int tick = (static_cast<int>(w) + k) * kTicksPerStep;
        EXPECT_NEAR(windows[w].input(k, lag * kTick_s)[5], mean_before(0.003, 0.0, tick, lag),
                    1e-12);
      }
}

TEST(TargetLag, WhereTargetsBendItIsOffByLittleOfWhatTheLagIs) {
  constexpr double kBend = 2e-5;  // rad per tick^2: 0.4 rad/s^2
  const PredictionWindow w = windows_of(with_targets(0.0, kBend)).at(2);
  const int tick = 2 * kTicksPerStep + 5 * kTicksPerStep;
  const double exact = mean_before(0.0, kBend, tick, 3.0);
  const double without = std::abs(w.u[5][0] - exact);
  EXPECT_LT(std::abs(w.input(5, 0.03)[0] - exact), 0.1 * without);
}

TEST(TargetLag, BeforeTheFirstTickTheFirstTargetsAreTakenForHeld) {
  const auto windows = windows_of(with_targets(0.003, 0.0));
  EXPECT_TRUE(windows[0].u_before == windows[0].u[0]);
  EXPECT_TRUE(windows[1].u_before == windows[0].u[0]) << "and then they are what was recorded";
  EXPECT_FALSE(windows[1].u_before == windows[1].u[0]);
}

TEST(TargetLag, CutWindowsHaveTheSame) {
  Episode e = with_targets(0.003, 0.0);
  const auto whole = windows_of(e);
  for (std::size_t i = 0; i < e.ticks.size(); ++i) e.ticks[i].tick = i;  // wraps below zero
  const auto cut = cut_windows_of(e.ticks, 0, 3.2);                      // wherever the robot leans
  ASSERT_GE(cut.size(), whole.size());
  for (std::size_t w = 0; w < whole.size(); ++w)
    EXPECT_TRUE(cut[w].u_before == whole[w].u_before) << "window " << w;
}

TEST(TargetLag, ALateRobotIsPredictedByAModelThatKnowsIt) {
  model::ModelParameters late = model::nominal_parameters();
  late.target_lag_s = 0.02;
  const Episode e = episode_of_world(0);
  std::vector<PredictionWindow> windows = windows_of(e);
  // the robot of these windows does what a model with the lag says
  const model::StepModel knows = model::make_step_model(late);
  for (PredictionWindow& w : windows) {
    const auto states = predicted(w, knows, model::make_plane());
    for (int k = 1; k <= kPredictionSteps; ++k) w.x[k] = states[static_cast<std::size_t>(k)];
  }
  const auto loss = [&](const model::StepModel& m) {
    return n_step_loss(windows, m, model::make_plane(), weights());
  };
  EXPECT_LT(loss(knows), 1e-20);
  EXPECT_GT(loss(model::make_step_model(model::nominal_parameters())), 1e-6);
}

}  // namespace
}  // namespace sanso::learn
