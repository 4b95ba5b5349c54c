// What a short or bad recording is worth: windows that end before the fall, and a model learned
// from them.
#include <gtest/gtest.h>

#include "tests/host/learn/model/learner_world.h"

namespace sanso::learn {
namespace {

constexpr double kTilt = 0.5;
constexpr int kShort = 31;  // 0.3 s and its last state

/// The first `ticks` of a trial that ended in a fall.
Episode cut_short(std::uint32_t trial, int ticks) {
  Episode e = episode_of_world(trial);
  e.ticks.resize(static_cast<std::size_t>(ticks));
  for (std::size_t i = 0; i < e.ticks.size(); ++i) e.ticks[i].tick = 1000 + i;
  e.end = TrialEnd::tilt;
  return e;
}

std::vector<int> steps_of(const std::vector<PredictionWindow>& windows) {
  std::vector<int> steps;
  for (const PredictionWindow& w : windows) steps.push_back(w.steps);
  return steps;
}

TEST(CutWindows, ARecordingOf300msGivesOneWindowForEveryStepThatItHas) {
  EXPECT_TRUE(windows_of(cut_short(0, kShort)).empty()) << "the premise: too short for N steps";
  EXPECT_EQ(steps_of(cut_windows_of(cut_short(0, kShort).ticks, 0, kTilt)),
            (std::vector<int>{5, 4, 3, 2, 1}));
  EXPECT_TRUE(cut_windows_of(cut_short(0, kTicksPerStep).ticks, 0, kTilt).empty())
      << "60 ms lack their last state";
}

TEST(CutWindows, EndBeforeTheRobotLeansAndBeforeAGap) {
  Episode e = cut_short(0, kShort);
  e.ticks[18].x.segment<4>(model::kXQuat) =
      math::quat_exp(math::Vec3(0.0, 1.1 * kTilt, 0.0));  // the state after three steps
  EXPECT_EQ(steps_of(cut_windows_of(e.ticks, 0, kTilt)), (std::vector<int>{2, 1, 1}))
      << "also the window behind, once it is upright again";
  Episode gap = cut_short(0, kShort);
  gap.ticks.erase(gap.ticks.begin() + 14);
  EXPECT_EQ(steps_of(cut_windows_of(gap.ticks, 0, kTilt)), (std::vector<int>{2, 1, 2, 1}));
}

TEST(CutWindows, OfALongRecordingHoldTheWholeOnesAsTheyAre) {
  const Episode e = cut_short(0, kTicks);
  const auto whole = upright_windows_of(e, kTilt);
  ASSERT_GT(whole.size(), 5u);
  auto cut = cut_windows_of(e.ticks, 0, kTilt);
  std::erase_if(cut, [](const PredictionWindow& w) { return w.steps < kPredictionSteps; });
  ASSERT_EQ(cut.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_TRUE(cut[i].x[0] == whole[i].x[0]);
    EXPECT_TRUE(cut[i].x[kPredictionSteps] == whole[i].x[kPredictionSteps]);
    EXPECT_TRUE(cut[i].u[kPredictionSteps - 1] == whole[i].u[kPredictionSteps - 1]);
  }
}

TEST(CutWindows, TheirLossCountsTheirStepsAndNoOthers) {
  const model::StepModel nominal = model::make_step_model(model::nominal_parameters());
  const auto windows = cut_windows_of(cut_short(0, kShort).ticks, 0, kTilt);
  double sum = 0.0;
  int steps = 0;
  for (const PredictionWindow& w : windows) {
    const auto states = predicted(w, nominal, model::make_plane(), nullptr);
    for (int k = 1; k <= w.steps; ++k) {
      const model::Tangent e = model::minus(w.x[k], states[static_cast<std::size_t>(k)]);
      sum += e.dot(weights().cwiseProduct(e));
      ++steps;
    }
  }
  const double loss = n_step_loss(windows, nominal, model::make_plane(), weights());
  EXPECT_NEAR(loss, sum / steps, 1e-9 * loss);
}

/// The loss on an unseen whole trial after a round from `from`, relative to that of the first
/// model.
double learned_from(const std::vector<Episode>& from) {
  ModelLearner learner({}, weights(), {}, kSeed);
  learner.learn(from);
  const ModelLosses unseen = learner.losses(episode_of_world(99)).value();
  return unseen.augmented / unseen.initial;
}

TEST(ModelLearner, LearnsFromRobotsThatFellAfter300ms) {
  EXPECT_LT(learned_from({cut_short(0, kShort), cut_short(1, kShort), cut_short(2, kShort)}), 0.5);
}

TEST(ModelLearner, LearnsFromTheHoldOfARobotThatNeverBegan) {
  std::vector<Episode> fell;
  for (std::uint32_t t = 0; t < 3; ++t) {
    Episode e = cut_short(t, 100);
    e.end = TrialEnd::fell_before;
    e.before.swap(e.ticks);
    for (wire::Observation& o : e.before) o.trial_tick = -1;
    fell.push_back(e);
  }
  EXPECT_LT(learned_from(fell), 0.5);
  for (Episode& e : fell) e.end = TrialEnd::completed;
  EXPECT_EQ(learned_from(fell), 1.0) << "a trial that ran has shown more than the hold before it";
}

}  // namespace
}  // namespace sanso::learn
