// Prediction errors: nothing at the truth, derivatives, what starts can explain, branches, chance.
#include "tools/diagnose/compare/prediction_error.h"

#include "tools/diagnose/compare/start_elimination.h"

#include <gtest/gtest.h>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using namespace test;

Eigen::VectorXd random_error(const Problem& problem, std::uint64_t seed) {
  Random random(seed);
  Eigen::VectorXd r(static_cast<Eigen::Index>(problem->size));
  for (double& e : r) e = random.normal();
  return r;
}

/// Mean square of the median shot, starts taken out: a start in the middle of a stop is known
/// badly.
double level(const SmallComparison& c, const Model& at, const Model& model) {
  const StartElimination starts(c.problem, c.library, at);
  const Eigen::VectorXd energy =
      starts.energy_by_shot(prediction_error(c.problem, c.library, model));
  std::vector<double> by_shot;
  for (std::size_t s = 0; s < c.problem->shots.size(); ++s)
    by_shot.push_back(energy[s] /
                      static_cast<double>(c.problem->shots[s].rows * c.problem->channels.size()));
  return median(by_shot);
}

TEST(PredictionError, IsNoiseAtTheTruthAndMuchMoreWithoutIt) {
  const SmallComparison c =
      compared(pendulum(kNoisyServo), {hidden("coulomb_friction", "a", {{"coulomb", 0.08}})},
               {"coulomb_friction"}, 1);
  const Model truth = with(c, c.of("coulomb_friction"), {0.08});
  EXPECT_NEAR(level(c, truth, truth), 1.0, 0.4);
  EXPECT_GT(level(c, truth, nominal(c)), 30.0);
}

TEST(PredictionError, VanishesAtTheTruthWithoutNoise) {
  const SmallComparison c =
      compared(pendulum(kNoisyServo), {hidden("coulomb_friction", "a", {{"coulomb", 0.08}})},
               {"coulomb_friction"}, 0);
  const Model truth = with(c, c.of("coulomb_friction"), {0.08});
  EXPECT_LT(level(c, truth, truth), 0.03);
}

TEST(PredictionError, DoesNotDependOnTheOrderOfTheRecordings) {
  const ModelFolder model = pendulum(kNoisyServo);
  auto recordings = recordings_of(model, 2, 4.0, 1);
  const SmallComparison a(model, recordings, noise_of(model), {"coulomb_friction"});
  std::swap(recordings[0], recordings[1]);
  const SmallComparison b(model, recordings, noise_of(model), {"coulomb_friction"});
  EXPECT_NEAR(prediction_error(a.problem, a.library, nominal(a)).squaredNorm(),
              prediction_error(b.problem, b.library, nominal(b)).squaredNorm(), 1e-6);
}

TEST(PredictionError, NearIsTheSameWhereverTheModelDiffers) {
  const SmallComparison c = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const Eigen::VectorXd base = prediction_error(c.problem, c.library, nominal(c));
  const Model other = with(c, c.of("coulomb_friction", {1}), {0.05});
  EXPECT_EQ(prediction_error_near(c.problem, c.library, other, base, {1}),
            prediction_error(c.problem, c.library, other));
  EXPECT_EQ(prediction_error_near(c.problem, c.library, other, base, {}),
            prediction_error(c.problem, c.library, other));
}

TEST(PredictionError, WithLostCommandsIsThatOfTheCommandsReceived) {
  SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const Model model = nominal(c);
  const std::vector<LostCommand> lost{{0, 0, 120}, {0, 0, 121}, {1, 0, 60}};
  const Eigen::VectorXd base = prediction_error(c.problem, c.library, model);
  const Eigen::VectorXd direct = prediction_error_with_lost(
      c.problem, c.library, model, base, lost, std::vector<char>(c.problem->shots.size(), 1), {0});
  const Problem received = with_lost(c.problem, lost);
  EXPECT_LT((direct - prediction_error(received, c.library, model)).norm(), 1e-9);
  EXPECT_GT((direct - base).norm(), 1.0) << "they would be noticed";
}

TEST(PredictionError, ShotsThatAreNotWantedStayAsTheyWere) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const Eigen::VectorXd base = random_error(c.problem, 3);
  std::vector<char> wanted(c.problem->shots.size(), 0);
  wanted[2] = 1;
  const Eigen::VectorXd r =
      prediction_error_with_lost(c.problem, c.library, nominal(c), base, {}, wanted, {0});
  for (std::size_t s = 0; s < c.problem->shots.size(); ++s) {
    const Shot& shot = c.problem->shots[s];
    const std::size_t all = c.problem->channels.size();
    EXPECT_EQ(rows_of(r, shot, 0, all) == rows_of(base, shot, 0, all), s != 2) << s;
  }
}

TEST(PredictionError, DrawsOfChanceAreTheirSeeds) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"packet_loss"}, 1);
  const Model lossy = with(c, c.of("packet_loss"), {0.2});
  const auto draw = [&](std::uint64_t seed) {
    return drawn_prediction_error(c.problem, c.library, lossy, seed);
  };
  EXPECT_EQ(draw(5), draw(5));
  EXPECT_GT((draw(5) - draw(6)).norm(), 1.0);
}

TEST(PredictionError, AStepThatIsCorrectedIsThatOfSmallSteps) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 0);
  const Eigen::VectorXd coarse = prediction_error(c.problem, c.library, nominal(c));
  Comparison in_small_steps = *c.problem;
  in_small_steps.settings.fitting.search_step = 2.5e-4;
  const Problem small{std::make_shared<const Comparison>(in_small_steps), c.problem.scales};
  const Eigen::VectorXd fine = prediction_error(small, c.library, nominal(c));
  const Eigen::VectorXd corrected =
      prediction_error(step_corrected(c.problem, c.library, nominal(c)), c.library, nominal(c));
  EXPECT_LT((corrected - fine).norm(), 0.5 * (coarse - fine).norm());
}

class Starts : public ::testing::Test {
 protected:
  SmallComparison c_ = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1);
  StartElimination starts_{c_.problem, c_.library, nominal(c_)};
  Eigen::VectorXd a_ = random_error(c_.problem, 1), b_ = random_error(c_.problem, 2);
};

TEST_F(Starts, EliminationIsSymmetric) {
  EXPECT_NEAR(a_.dot(starts_.project(b_)), b_.dot(starts_.project(a_)), 1e-8);
}

TEST_F(Starts, EliminationTakesEnergyAndNeverMoreThanThereIs) {
  const double energy = a_.dot(starts_.project(a_));
  EXPECT_GT(energy, 0.0);
  EXPECT_LT(energy, a_.squaredNorm());
  EXPECT_LE(starts_.project(a_).norm(), a_.norm());
}

TEST_F(Starts, EnergyByShotAddsUpToTheGram) {
  Eigen::MatrixXd two(a_.size(), 2);
  two << a_, b_;
  const Eigen::MatrixXd gram = starts_.gram(two);
  EXPECT_NEAR(starts_.energy_by_shot(a_).sum(), gram(0, 0), 1e-7);
  EXPECT_NEAR(gram(0, 1), a_.dot(starts_.project(b_)), 1e-7);
  EXPECT_NEAR(gram(0, 1), gram(1, 0), 1e-9);
}

TEST_F(Starts, GramsOfTheGroupsAddUp) {
  const Eigen::MatrixXf two =
      (Eigen::MatrixXf(a_.size(), 2) << a_.cast<float>(), b_.cast<float>()).finished();
  const Eigen::VectorXd ones =
      Eigen::VectorXd::Ones(static_cast<Eigen::Index>(c_.problem->shots.size()));
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(2, 2);
  for (const Eigen::MatrixXd& g : starts_.gram_by_group(two, ones)) sum += g;
  EXPECT_LT((sum - starts_.gram(two, ones)).norm(), 1e-3);
}

TEST_F(Starts, WhatAMovedStartMakesIsExplainedByTheStart) {
  const Eigen::VectorXd base = prediction_error(c_.problem, c_.library, nominal(c_));
  const Remembered known(c_.problem, c_.library, nominal(c_));
  for (std::size_t joint = 0; joint < 2; ++joint) {
    const Eigen::VectorXd change =
        prediction_error_from_moved_start(c_.problem, c_.library, nominal(c_), joint, 2e-4, 2e-3,
                                          known) -
        base;
    EXPECT_GT(change.squaredNorm(), 1.0);
    EXPECT_LT(change.dot(starts_.project(change)), 0.35 * change.squaredNorm()) << joint;
  }
}

TEST_F(Starts, WeightsOfShotsAreFactors) {
  Eigen::MatrixXd one = a_;
  const auto n = static_cast<Eigen::Index>(c_.problem->shots.size());
  EXPECT_NEAR(starts_.gram(one, Eigen::VectorXd::Constant(n, 3.0))(0, 0),
              3.0 * starts_.gram(one)(0, 0), 1e-7);
}

}  // namespace
}  // namespace sanso::diagnose
