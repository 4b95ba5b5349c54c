// Lanes against the plain scalar model: roll-outs equal, derivatives equal to high-order
// differences through contact on and off, on every instruction set this machine has.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "host/mpc/op3_phases.h"
#include "shared/grounds/ground_file.h"
#include "tests/host/mpc/support/problems.h"
#include "tests/host/mpc/support/reference_model.h"

namespace sanso::mpc {
namespace {

using model::Input;
using model::State;
using model::Tangent;

/// The model with joints whose zeros are off, on a ground that is not where it is drawn.
model::StepModel put_together_by_hand(model::StepModel model, std::mt19937& random) {
  std::normal_distribution<double> normal;
  for (model::ServoParameters& servo : model.servo) servo.zero = 0.02 * normal(random);
  model.ground_height = 0.003 * normal(random);
  return model;
}

struct DrawnProblem {
  explicit DrawnProblem(unsigned seed, bool residual, bool middle, const LaneKernels& kernels,
                        const model::Ground& ground)
      : random(seed), pool(1, false) {
    model.ground = ground;
    model.analytical = put_together_by_hand(model.analytical, random);
    if (residual) model.residual = problems::random_network(seed);
    phases = std::make_unique<Op3Phases>(Op3PhasesSettings{}, model, pool, kernels);
    reference = problems::reference_of("walk_forward");
    tick = static_cast<int>(
        std::uniform_int_distribution<std::size_t>(0, reference.size() - 1)(random));
    context =
        problems::make_context(reference, tick, 12, CostWeights{}, middle ? &random : nullptr);
    phases->context() = *context;
    trajectory = std::make_unique<Trajectory>();
    std::normal_distribution<double> normal;
    const State x0 = model::plus(reference[static_cast<std::size_t>(tick)],
                                 problems::random_disturbance(random));
    std::copy_n(x0.data(), kNx, trajectory->x[0]);
    for (auto& u : trajectory->u)
      for (int i = 0; i < kNu; ++i) u[i] = 0.03 * normal(random);
  }
  /// Fills the trajectory by the lanes' own roll-out.
  void roll_out() {
    lanes = std::make_unique<LaneTrajectories>();
    LinePolicy policy;
    policy.nominal = trajectory.get();
    policy.input_limit_rad = 0.5;
    phases->roll_out(policy, kStepLengths, *lanes);
    phases->lane_taken(3);
    for (int k = 0; k < 12; ++k)
      for (int i = 0; i < kNx; ++i) trajectory->x[k][i] = lanes->x(k, i, 3);
  }
  State x(int k) const { return Eigen::Map<const State>(trajectory->x[k]); }
  Input u(int k) const { return Eigen::Map<const Input>(trajectory->u[k]); }

  std::mt19937 random;
  host::AugmentedModel model;
  SpinPool pool;
  std::unique_ptr<Op3Phases> phases;
  std::vector<State> reference;
  int tick = 0;
  std::unique_ptr<ProblemContext> context;
  std::unique_ptr<Trajectory> trajectory;
  std::unique_ptr<LaneTrajectories> lanes;
};

std::vector<const LaneKernels*> all_kernels() {
  const LaneKernels* list[3];
  return {list, list + available_lane_kernels(list, 3)};
}

TEST(Lanes, RollOutEqualsTheScalarModel) {
  for (const LaneKernels* kernels : all_kernels())
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const bool residual = seed % 2 == 0, middle = seed % 3 == 0;
      SCOPED_TRACE(std::string(kernels->name) + " seed " + std::to_string(seed));
      DrawnProblem s(seed, residual, middle, *kernels,
                     seed == 5 ? grounds::load_ground("ramp") : model::make_plane());
      s.roll_out();
      const reference::Model scalar(s.model, *s.context, 0.06);
      // eleven steps with contact amplify rounding (single precision in the network) by some
      // thousands
      const double tolerance = residual ? 2e-3 : 1e-8;
      double cost = 0;
      State x = s.x(0);
      for (int k = 0; k < 12; ++k) {
        ASSERT_LT(model::minus(s.x(k), x).norm(), tolerance) << "knot " << k;
        cost += scalar.cost(k, x) + (k < 11 ? scalar.cost(s.u(k)) : 0.0);
        if (k < 11) {
          // one step from the lanes' own state: no amplification
          EXPECT_LT(model::minus(scalar.step(k, s.x(k), s.u(k)), s.x(k + 1)).norm(),
                    residual ? 1e-6 : 1e-9);
          x = scalar.step(k, x, s.u(k));
        }
      }
      EXPECT_NEAR(s.lanes->cost(0), cost, tolerance * (1 + cost));
      EXPECT_EQ(s.lanes->cost(0), s.lanes->cost(7));  // equal inputs, equal lanes
    }
}

/// The largest difference of one-sided slopes over the step the product uses: how far the function
/// is from a straight line there. Where contact switches inside the step it is large, and no single
/// number is "the" derivative.
double kink(const reference::Model& m, int k, const State& x, const Input& u, int column,
            double h) {
  const auto at = [&](double s) {
    if (column < kNdx) return m.step(k, model::plus(x, s * Tangent::Unit(column)), u);
    return m.step(k, x, u + s * Input::Unit(column - kNdx));
  };
  const State middle = at(0);
  return (model::minus(at(h), middle) + model::minus(at(-h), middle)).norm() / h;
}

TEST(Lanes, DerivativesEqualCentralDifferencesThroughContactOnAndOff) {
  int compared = 0, kinks = 0, touching = 0, flying = 0;
  for (const LaneKernels* kernels : all_kernels())
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE(std::string(kernels->name) + " seed " + std::to_string(seed));
      DrawnProblem s(seed, seed % 2 == 0, seed >= 3, *kernels,
                     seed == 4 ? grounds::load_ground("ramp") : model::make_plane());
      // starts in the air: the first steps have no contact
      if (seed == 1) s.trajectory->x[0][2] += 0.1;
      s.roll_out();
      auto d = std::make_unique<StageDerivatives[]>(kMaxStages);
      auto c = std::make_unique<StageCost[]>(kMaxHorizon);
      s.phases->linearize(*s.trajectory, d.get(), c.get());
      const reference::Model tight(s.model, *s.context, 0.06);
      for (int k = 0; k < 11; k += 3) {
        (s.x(k)[2] > 0.33 ? flying : touching) += 1;
        for (int column = 0; column < kColumns; ++column) {
          if (kink(tight, k, s.x(k), s.u(k), column, 1e-4) > 0.02) {
            ++kinks;
            continue;
          }
          const Tangent truth = tight.column(k, s.x(k), s.u(k), column, 1e-5);
          Tangent lanes;
          for (int i = 0; i < kNdx; ++i) lanes[i] = d[k].AB[i][column];
          // half the kink the forward step may see (0.01), doubled: the truth's step is ten times
          // as long
          EXPECT_LT((lanes - truth).norm(), 0.02 + 0.02 * truth.norm())
              << "stage " << k << " column " << column;
          ++compared;
        }
      }
    }
  EXPECT_GT(compared, 10 * kinks) << compared << " compared, " << kinks << " kinks";
  EXPECT_GT(touching, 0);
  EXPECT_GT(flying, 0);
}

TEST(Lanes, ResidualNetworkAndOtherLayersEnterTheDerivativesExactly) {
  // in the air the analytical step is smooth, so what is left is the network, the middle layer and
  // the reflex
  for (const LaneKernels* kernels : all_kernels()) {
    SCOPED_TRACE(kernels->name);
    DrawnProblem with(7, true, true, *kernels, model::make_plane());
    with.trajectory->x[0][2] += 1.0;
    with.roll_out();
    auto d = std::make_unique<StageDerivatives[]>(kMaxStages);
    auto c = std::make_unique<StageCost[]>(kMaxHorizon);
    with.phases->linearize(*with.trajectory, d.get(), c.get());
    const reference::Model scalar(with.model, *with.context, 0.06);
    for (int k = 0; k < 4; ++k) {
      const reference::Jacobian truth = scalar.central_differences(k, with.x(k), with.u(k), 1e-5);
      for (int i = 0; i < kNdx; ++i)
        for (int j = 0; j < kColumns; ++j)
          ASSERT_NEAR(d[k].AB[i][j], truth(i, j), 2e-3)
              << "stage " << k << " row " << i << " column " << j;
      // noise direction: the step without the upper layer's input
      const Tangent F = model::minus(scalar.step(k, with.x(k), with.u(k)),
                                     scalar.step(k, with.x(k), Input::Zero()));
      for (int i = 0; i < kNdx; ++i)
        ASSERT_NEAR(d[k].F[i], F[i], 1e-6) << "stage " << k << " row " << i;
    }
  }
}

/// Largest difference of two stages' derivatives.
double difference(const StageDerivatives& a, const StageDerivatives& b) {
  double largest = 0;
  for (int i = 0; i < kNdx; ++i)
    for (int j = 0; j < kColumns; ++j)
      largest = std::max(largest, std::abs(a.AB[i][j] - b.AB[i][j]));
  return largest;
}

TEST(Lanes, AKeptJacobianOfTheNetworkIsUsedNearItsPointAndNowhereElse) {
  const auto at = [](Op3Phases& phases, const Trajectory& trajectory, StageDerivatives* out) {
    auto costs = std::make_unique<StageCost[]>(kMaxHorizon);
    phases.linearize(trajectory, out, costs.get());
  };
  for (const LaneKernels* kernels : all_kernels()) {
    SCOPED_TRACE(kernels->name);
    DrawnProblem s(7, true, false, *kernels, model::make_plane());
    s.trajectory->x[0][2] += 1.0;
    s.roll_out();
    auto first = std::make_unique<StageDerivatives[]>(kMaxStages),
         kept = std::make_unique<StageDerivatives[]>(kMaxStages),
         fresh = std::make_unique<StageDerivatives[]>(kMaxStages);
    int same_as_fresh = 0;
    for (const double rate : {0.001, 0.03, 0.3, 3.0}) {  // rad/s, of the knees
      auto moved = std::make_unique<Trajectory>(*s.trajectory);
      for (auto& x : moved->x) x[model::kXJointRate + 3] += rate, x[model::kXJointRate + 9] += rate;
      s.phases->begin_solve();
      at(*s.phases, *s.trajectory, first.get());
      at(*s.phases, *moved, kept.get());
      s.phases->begin_solve();
      at(*s.phases, *moved, fresh.get());
      for (int k = 0; k < 11; ++k) {
        const double wrong = difference(kept[k], fresh[k]),
                     by_network = difference(first[k], fresh[k]);
        // 0.02 of a slope in both layers, of what the network may be
        EXPECT_LE(wrong, 0.02) << "stage " << k << ", " << rate << " rad/s, of " << by_network;
        same_as_fresh += wrong == 0.0;
      }
    }
    EXPECT_GE(same_as_fresh, 11);  // far away nothing is kept
    EXPECT_LE(same_as_fresh, 33);  // nearby it is
  }
}

TEST(Lanes, AnotherNetworkBeginsWithoutTheLastOnesJacobian) {
  DrawnProblem s(7, true, false, lane_kernels(), model::make_plane());
  s.trajectory->x[0][2] += 1.0;
  s.roll_out();
  auto with = std::make_unique<StageDerivatives[]>(kMaxStages),
       after = std::make_unique<StageDerivatives[]>(kMaxStages),
       fresh = std::make_unique<StageDerivatives[]>(kMaxStages);
  auto costs = std::make_unique<StageCost[]>(kMaxHorizon);
  s.phases->linearize(*s.trajectory, with.get(), costs.get());
  host::AugmentedModel other = s.model;
  other.residual->W3 *= 0.5;  // the same slopes everywhere
  s.phases->set_model(other);
  s.phases->linearize(*s.trajectory, after.get(), costs.get());
  s.phases->begin_solve();
  s.phases->linearize(*s.trajectory, fresh.get(), costs.get());
  EXPECT_GT(difference(with[0], fresh[0]), 1e-6);
  for (int k = 0; k < 11; ++k) EXPECT_EQ(difference(after[k], fresh[k]), 0.0) << "stage " << k;
}

TEST(Lanes, CostModelEqualsDifferencesOfTheCost) {
  DrawnProblem s(9, false, false, lane_kernels(), model::make_plane());
  const reference::Model m(s.model, *s.context, 0.06);
  StageCost cost;
  const State x = s.x(0);
  const Input u = s.u(0);
  cost_model(*s.context, 0, x.data(), u.data(), cost);
  constexpr double h = 1e-5;
  for (int i = 0; i < kNdx; ++i) {
    const double slope = (m.cost(0, model::plus(x, h * Tangent::Unit(i))) -
                          m.cost(0, model::plus(x, -h * Tangent::Unit(i)))) /
                         (2 * h);
    EXPECT_NEAR(cost.lx[i], slope, 1e-6) << i;
  }
  for (int i = 0; i < kNu; ++i)
    EXPECT_NEAR(
        cost.lu[i],
        (m.cost(Input(u + h * Input::Unit(i))) - m.cost(Input(u - h * Input::Unit(i)))) / (2 * h),
        1e-8);
}

TEST(Lanes, ThreadsDoNotChangeABit) {
  DrawnProblem one(11, true, true, lane_kernels(), model::make_plane());
  one.roll_out();
  auto d1 = std::make_unique<StageDerivatives[]>(kMaxStages),
       d4 = std::make_unique<StageDerivatives[]>(kMaxStages);
  auto c = std::make_unique<StageCost[]>(kMaxHorizon);
  one.phases->linearize(*one.trajectory, d1.get(), c.get());
  SpinPool pool(4, false);
  const SpinPool::Session session(pool);
  Op3Phases many({}, one.model, pool, lane_kernels());
  many.context() = *one.context;
  auto lanes = std::make_unique<LaneTrajectories>();
  LinePolicy policy;
  policy.nominal = one.trajectory.get();
  policy.input_limit_rad = 0.5;
  many.roll_out(policy, kStepLengths, *lanes);
  for (int lane = 0; lane < kLineSearchLanes; ++lane)
    ASSERT_EQ(one.lanes->cost(lane), lanes->cost(lane));
  for (int i = 0; i < kNx; ++i) ASSERT_EQ(one.lanes->x(11, i, 7), lanes->x(11, i, 7));
  many.lane_taken(3);
  many.linearize(*one.trajectory, d4.get(), c.get());
  for (int k = 0; k < 11; ++k)
    for (int i = 0; i < kNdx; ++i)
      for (int j = 0; j < kColumns; ++j) ASSERT_EQ(d1[k].AB[i][j], d4[k].AB[i][j]);
}

}  // namespace
}  // namespace sanso::mpc
