// Noise with slopes: its columns are differences of the very models, and what a roll-out is said to
// cost beside the nominal is what they make there.
#include "host/mpc/noise_phases.h"

#include <gtest/gtest.h>

#include "host/mpc/solver.h"
#include "tests/host/mpc/support/problems.h"
#include "tests/host/mpc/support/reference_model.h"

namespace sanso::mpc {
namespace {

using model::Input;
using model::State;
using model::Tangent;

/// The nominal robot, and two that are heavier and softer.
host::AugmentedModel with_spread() {
  host::AugmentedModel out;
  for (const double more : {1.03, 0.95}) {
    model::ModelParameters p = model::nominal_parameters();
    for (auto& body : p.body) body.mass *= more;
    for (auto& servo : p.servo) servo.stiffness /= more * more;
    out.spread.push_back(model::make_step_model(p));
  }
  return out;
}

struct Case {
  explicit Case(const NoiseSettings& noise)
      : model(with_spread()),
        reference_states(problems::reference_of("walk_forward")),
        context(problems::make_context(reference_states, 50, 12, CostWeights{})),
        nominal({}, model, pool),
        phases(noise, {}, nominal, pool) {
    phases.set_model(model);
    nominal.context() = *context;
    std::mt19937 random(5);
    const State x0 = model::plus(reference_states[50], problems::random_disturbance(random, 0.3));
    std::copy_n(x0.data(), kNx, trajectory().x[0]);
    std::normal_distribution<double> normal;
    for (int k = 0; k < phases.stages(); ++k)
      for (int i = 0; i < kNu; ++i) trajectory().u[k][i] = 0.03 * normal(random);
  }
  Trajectory& trajectory() { return start->trajectory; }

  /// Rolls the inputs out and linearises there.
  void linearize() {
    LinePolicy policy;
    policy.nominal = &trajectory();
    policy.input_limit_rad = 0.5;
    phases.roll_out(policy, kStepLengths, start->lanes);
    for (int k = 0; k <= phases.stages(); ++k)
      for (int i = 0; i < kNx; ++i) trajectory().x[k][i] = start->lanes.x(k, i, 0);
    phases.lane_taken(0);
    phases.linearize(trajectory(), start->derivatives, start->costs);
  }

  struct Start {
    Trajectory trajectory{};
    LaneTrajectories lanes{};
    StageDerivatives derivatives[kMaxStages];
    StageCost costs[kMaxHorizon];
  };
  host::AugmentedModel model;
  std::vector<State> reference_states;
  std::unique_ptr<ProblemContext> context;
  SpinPool pool{1, false};
  Op3Phases nominal;
  NoisePhases phases;
  std::unique_ptr<Start> start = std::make_unique<Start>();
};

/// Largest deviation of the column of a stage from F and its central differences, relative to the
/// largest slope there is.
template <class F>
double deviation(const NoiseColumn& column, const Trajectory& t, int k, const F& noise) {
  const State x = Eigen::Map<const State>(t.x[k]);
  const Input u = Eigen::Map<const Input>(t.u[k]);
  const double h = 1e-5;
  double worst = 0, largest = 1e-3;
  const Tangent c = noise(x, u);
  for (int i = 0; i < kNdx; ++i) worst = std::max(worst, std::abs(column.c[i] - c[i]));
  for (int j = 0; j < kColumns; ++j) {
    const auto at = [&](double s) {
      return j < kNdx ? noise(model::plus(x, s * Tangent::Unit(j)), u)
                      : noise(x, u + s * Input::Unit(j - kNdx));
    };
    const Tangent slope = (at(h) - at(-h)) / (2 * h);
    for (int i = 0; i < kNdx; ++i) {
      worst = std::max(worst, std::abs(column.D[i][j] - slope[i]));
      largest = std::max(largest, std::abs(slope[i]));
    }
  }
  return worst / largest;
}

TEST(NoisePhases, ColumnsAreDifferencesOfTheModelsAndTheirSlopes) {
  Case a({.input_slope = true, .spread = 1.0});
  a.linearize();
  const NoiseColumns columns = a.phases.noise_columns(0.7);
  ASSERT_EQ(columns.count, 3);
  EXPECT_TRUE(columns.of_input);
  EXPECT_DOUBLE_EQ(columns.variance[0], 0.49);
  EXPECT_DOUBLE_EQ(columns.variance[1], 0.5) << "two members share an amplitude of one";
  const reference::Model m(a.model, *a.context, 0.06);
  int far = 0;
  for (int k = 0; k < a.phases.stages(); ++k) {
    const double of_input = deviation(
        columns.stage[k].column[0], a.trajectory(), k, [&](const State& x, const Input& u) {
          return Tangent(model::minus(m.step(k, x, u), m.step(k, x, Input::Zero())));
        });
    far += of_input > 0.05;
    for (std::size_t e = 0; e < 2; ++e) {
      host::AugmentedModel other = a.model;
      other.analytical = a.model.spread[e];
      const reference::Model member(other, *a.context, 0.06);
      const double of_member = deviation(
          columns.stage[k].column[1 + e], a.trajectory(), k, [&](const State& x, const Input& u) {
            return Tangent(model::minus(member.step(k, x, u), m.step(k, x, u)));
          });
      far += of_member > 0.05;
    }
  }
  // a contact that changes within the central difference is held in the product
  EXPECT_LE(far, 3) << "of " << 3 * a.phases.stages();
}

TEST(NoisePhases, WithoutSlopesAndSpreadThereAreNoColumns) {
  Case a({});
  a.linearize();
  EXPECT_EQ(a.phases.noise_columns(0.7).count, 0);
}

TEST(NoisePhases, ARollOutIsPricedWhereItLeads) {
  Case a({.input_slope = true, .spread = 1.0});
  a.linearize();
  const NoiseColumns columns = a.phases.noise_columns(0.7);
  const auto gains = std::make_unique<StageGains[]>(kMaxStages);
  const auto prices = std::make_unique<ColumnsPrice[]>(kMaxStages);
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  for (int k = 0; k < a.phases.stages(); ++k) {
    for (double& step : gains[k].k) step = 0.02 * normal(random);
    // under the value |d|^2 / 2: the sum of the columns' squares
    prices[k].at = 0;
    std::fill_n(prices[k].slope, kColumns, 0.0);
    std::fill_n(&prices[k].curvature[0][0], kColumns * kColumns, 0.0);
    for (int e = 0; e < columns.count; ++e) {
      const NoiseColumn& n = columns.stage[k].column[e];
      for (int i = 0; i < kNdx; ++i) {
        prices[k].at += columns.variance[e] * n.c[i] * n.c[i];
        for (int j = 0; j < kColumns; ++j) {
          prices[k].slope[j] += columns.variance[e] * n.c[i] * n.D[i][j];
          for (int l = 0; l < kColumns; ++l)
            prices[k].curvature[j][l] += columns.variance[e] * n.D[i][j] * n.D[i][l];
        }
      }
    }
  }
  LinePolicy policy;
  policy.nominal = &a.trajectory();
  policy.gains = gains.get();
  policy.columns = prices.get();
  policy.input_limit_rad = 0.5;
  a.phases.roll_out(policy, kStepLengths, a.start->lanes);
  for (int lane = 0; lane < kLineSearchLanes; ++lane) {
    double sum = 0;
    for (int k = 0; k < a.phases.stages(); ++k) {
      State x;
      for (int i = 0; i < kNx; ++i) x[i] = a.start->lanes.x(k, i, lane);
      Eigen::Matrix<double, kColumns, 1> d;
      d.head<kNdx>() = model::minus(x, Eigen::Map<const State>(a.trajectory().x[k]));
      for (int i = 0; i < kNu; ++i)
        d[kNdx + i] = a.start->lanes.u(k, i, lane) - a.trajectory().u[k][i];
      for (int e = 0; e < columns.count; ++e)
        for (int i = 0; i < kNdx; ++i) {
          const NoiseColumn& n = columns.stage[k].column[e];
          const double F = n.c[i] + Eigen::Map<const decltype(d)>(n.D[i]).dot(d);
          sum += 0.5 * columns.variance[e] * F * F;
        }
    }
    EXPECT_NEAR(a.start->lanes.noise_cost(lane), sum, 1e-9 * sum) << "lane " << lane;
    EXPECT_GT(sum, 0.0);
  }
}

}  // namespace
}  // namespace sanso::mpc
