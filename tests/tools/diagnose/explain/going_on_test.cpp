// Constant velocity as a baseline: exact where a joint goes on, far off where it is moved, and what
// a model has to beat before its effects are names.
#include "tools/diagnose/explain/going_on.h"

#include <gtest/gtest.h>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A pendulum whose recorded positions are replaced by `position(t)` with noise.
template <class Position>
SmallComparison moved_as(const Position& position) {
  const ModelFolder model = pendulum(kNoisyServo);
  std::vector<recording::Recording> recordings = recordings_of(model, 1, 6.0, 3);
  SmallComparison c(model, recordings, noise_of(model), {"coulomb_friction"});
  std::vector<Source> sources = c.problem->sources;
  Random random(5);
  for (Source& s : sources) {
    for (std::size_t k = 0; k < s.drive.rows(); ++k) {
      s.drive.joints[0].q[k] = position(s.drive.t[k]) + kPositionNoise * random.normal();
      s.motion.q[0][k] = position(s.drive.t[k]);
      const double h = 1e-4;
      s.motion.dq[0][k] = (position(s.drive.t[k] + h) - position(s.drive.t[k] - h)) / (2 * h);
    }
  }
  c.problem = make_problem(std::move(sources), noise_of(model), ProblemOptions{}, Settings{});
  return c;
}

TEST(GoingOn, IsNoiseWhereAJointGoesOn) {
  const SmallComparison c = moved_as([](double t) { return 0.2 + 0.4 * t; });
  const Eigen::VectorXd energy = going_on_energy(c.problem, 0);
  const double rows = rows_of_a_joint(*c.problem);
  const double unit = std::pow(kPositionNoise / c.problem.scales.sigma[0], 2);
  EXPECT_NEAR(energy.sum(), rows * unit, 0.25 * rows * unit);
  EXPECT_GE(energy.minCoeff(), 0.0);
}

TEST(GoingOn, IsFarOffWhereAJointTurnsRound) {
  const SmallComparison still = moved_as([](double) { return 0.3; }),
                        turns = moved_as([](double t) { return 0.5 * std::sin(5.0 * t); });
  EXPECT_GT(going_on_energy(turns.problem, 0).sum(), 1e3 * going_on_energy(still.problem, 0).sum());
}

TEST(GoingOn, AModelThatKnowsTheMotionBeatsItAndAWrongOneDoesNot) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 9);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const Eigen::VectorXd r = prediction_error(c.problem, c.library, nominal(c));
  const Eigen::VectorXd model = position_energy(around, r, 0),
                        going = going_on_energy(c.problem, 0);
  EXPECT_GT(compare(DecisionSettings{}, going, model).certainty(), 2.0);
  // one channel only: its positions are all there is
  EXPECT_NEAR(model.sum(), around.starts.energy_by_shot(r).sum(), 1e-6 * model.sum());
  EXPECT_EQ(position_energy(around, r, 1).sum(), 0.0) << "there is no second joint";
}

}  // namespace
}  // namespace sanso::diagnose
