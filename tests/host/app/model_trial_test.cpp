// What the planner's own robot does with a motion: mechanics, and the clauses of the motion.
#include "host/app/model_trial.h"

#include <gtest/gtest.h>

#include <numeric>

#include "host/app/motion_judge.h"
#include "host/motion/make/compose.h"
#include "shared/model/step_model.h"

namespace sanso::app {
namespace {

motion::Motion squat(double height_m, const std::string& like = "squat") {
  const std::string recipe =
      "format = 1\ntitle = \"Down and up\"\nlike = \"" + like +
      "\"\nstand_s = 1.0\n[[pose]]\nat_s = 1.5\nheight_m = " + std::to_string(height_m) +
      "\n[[pose]]\nat_s = 3.0\n";
  return motion::compose_motion(recipe, "recipe", "squat").motion;
}

TEST(ModelTrial, OfASquatHoldsItsClauses) {
  const motion::Motion motion = squat(-0.04);
  const learn::Episode trial = trial_in_model(motion);
  EXPECT_EQ(trial.end, learn::TrialEnd::completed);
  EXPECT_EQ(trial.ticks.size(), motion.reference().x.size());
  EXPECT_EQ(trial.truth.size(), trial.ticks.size());
  EXPECT_TRUE(broken_clauses(motion, trial).empty()) << broken_clauses(motion, trial).front();
  const double sum = std::accumulate(trial.cost_terms.begin(), trial.cost_terms.end(), 0.0);
  EXPECT_DOUBLE_EQ(trial.cost, sum);
}

// Newton: over a motion that ends as it began the soles carry the weight, and what the IMU feels is
// the same force.
TEST(ModelTrial, TheFloorCarriesTheRobotAndTheImuFeelsIt) {
  const learn::Episode trial = trial_in_model(squat(-0.04));
  const model::StepModel robot = host::AugmentedModel{}.analytical;
  const double weight = robot.body[0].subtree_mass * model::kGravity_m_s2;
  double carried = 0.0, felt = 0.0;
  for (std::size_t k = 0; k < trial.ticks.size(); ++k) {
    for (const float load : trial.truth[k].foot_load_N) carried += static_cast<double>(load);
    felt += trial.ticks[k].imu_acc[2];
  }
  const auto n = static_cast<double>(trial.ticks.size());
  EXPECT_NEAR(carried / n, weight, 0.01 * weight);
  EXPECT_NEAR(felt / n, model::kGravity_m_s2, 0.05);
}

TEST(ModelTrial, RepeatsItself) {
  const motion::Motion motion = squat(-0.03);
  EXPECT_EQ(learn::digest(trial_in_model(motion)), learn::digest(trial_in_model(motion)));
}

// A robot whose servos hold nothing sinks, and the trial ends by the motion's own rule.
TEST(ModelTrial, EndsWhereTheStopRuleSays) {
  host::AugmentedModel limp;
  for (model::ServoParameters& servo : limp.analytical.servo) servo.torque_limit = 0.05;
  const learn::Episode trial = trial_in_model(squat(-0.03), limp);
  EXPECT_TRUE(trial.failed());
  EXPECT_LT(trial.ticks.size(), squat(-0.03).reference().x.size());
}

}  // namespace
}  // namespace sanso::app
