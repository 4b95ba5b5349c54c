// Members of an ensemble fit the data as well as the model they stand beside, and differ by what
// few and noisy windows leave open.
#include "host/learn/model/ensemble.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/host/learn/model/identify_windows.h"

namespace sanso::learn {
namespace {

const model::Ground kFloor = model::make_plane();
const model::Tangent kWeights = state_weights();
constexpr double kPrior = 1e-3;

model::ModelParameters softer_robot() {
  model::ModelParameters truth = model::nominal_parameters();
  for (auto& servo : truth.servo) servo.stiffness *= 0.9;
  truth.ground_height = 0.003;
  return truth;
}

/// Windows of that robot whose states were read with an error of `noise` (rad, m, tenfold rates).
std::vector<PredictionWindow> windows_read(int count, double noise) {
  std::vector<PredictionWindow> windows = windows_of_world(softer_robot(), count);
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (PredictionWindow& w : windows)
    for (int k = 0; k <= w.steps; ++k) {
      const model::Tangent error = model::Tangent::NullaryExpr(
          [&](Eigen::Index i) { return noise * normal(random) * (i < model::kNv ? 1.0 : 10.0); });
      w.x[k] = model::plus(w.x[k], error);
    }
  return windows;
}

struct Drawn {
  ParameterMap map{model::nominal_parameters()};
  std::vector<PredictionWindow> windows;
  Eigen::VectorXd z;
  std::vector<Eigen::VectorXd> members;

  Drawn(int count, double noise, int threads = 2, std::uint64_t seed = 1)
      : windows(windows_read(count, noise)) {
    const RefineProblem problem{windows, map, kFloor, kWeights};
    z = refined(problem, kPrior, Eigen::VectorXd::Zero(map.size()), {}, threads);
    members = ensemble(problem, kPrior, z, {.members = 4}, seed, threads);
  }
  double loss(const Eigen::VectorXd& at) const {
    return n_step_loss(windows, model::make_step_model(map.parameters(at)), kFloor, kWeights);
  }
  double spread() const {
    double sum = 0;
    for (const Eigen::VectorXd& member : members) sum += (member - z).squaredNorm();
    return std::sqrt(sum / static_cast<double>(members.size()));
  }
};

TEST(Ensemble, MembersFitAboutAsWellAsTheModelInUse) {
  const Drawn drawn(48, 0.002);
  ASSERT_EQ(drawn.members.size(), 4U);
  const double initial = drawn.loss(Eigen::VectorXd::Zero(drawn.map.size()));
  for (const Eigen::VectorXd& member : drawn.members) {
    EXPECT_GT((member - drawn.z).norm(), 0.0);
    EXPECT_LT(drawn.loss(member), drawn.loss(drawn.z) + 0.1 * (initial - drawn.loss(drawn.z)));
  }
}

TEST(Ensemble, DiffersLessWhereWindowsSayMore) {
  const Drawn exact(48, 0.0), noisy(48, 0.004), few(12, 0.004);
  EXPECT_LT(exact.spread(), 0.5 * noisy.spread()) << "less noise";
  EXPECT_LT(noisy.spread(), few.spread()) << "more windows";
}

TEST(Ensemble, IsOfItsSeedAlone) {
  const Drawn one(12, 0.002, 1), two(12, 0.002, 2), other(12, 0.002, 1, 2);
  EXPECT_EQ(one.members, two.members) << "whatever the threads";
  EXPECT_NE(one.members, other.members);
  EXPECT_TRUE(ensemble({one.windows, one.map, kFloor, kWeights}, kPrior, one.z, {}, 1, 1).empty())
      << "none are asked for by default";
}

}  // namespace
}  // namespace sanso::learn
