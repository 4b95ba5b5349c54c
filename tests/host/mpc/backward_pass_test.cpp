// The backward pass: equals Riccati on a linear problem, on every instruction set; noise shrinks
// gains; limits hold.
#include "host/mpc/backward_pass.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host/mpc/lane_kernels.h"

namespace sanso::mpc {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A random time-varying linear-quadratic problem in the solver's layout and in Eigen's.
struct LinearProblem {
  static constexpr int kStages = 11;
  std::vector<MatrixXd> A, B;
  std::vector<VectorXd> lx, lu, F;
  MatrixXd W, R;
  std::unique_ptr<StageDerivatives[]> derivatives{new StageDerivatives[kStages]()};
  std::unique_ptr<StageCost[]> costs{new StageCost[kStages + 1]()};
  double u[kStages][kNuPadded] = {};

  explicit LinearProblem(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const auto matrix = [&](int r, int c, double s) {
      return MatrixXd(MatrixXd::NullaryExpr(r, c, [&] { return s * normal(random); }));
    };
    W = MatrixXd::Zero(kNdx, kNdx);
    for (int i = 0; i < kNdx; ++i) W(i, i) = 0.5 + std::abs(normal(random));
    const MatrixXd theta = matrix(3, 3, 1.0);
    W.block<3, 3>(kTheta, kTheta) = theta * theta.transpose() + MatrixXd::Identity(3, 3);
    R = MatrixXd::Identity(kNu, kNu) * 1.5;
    for (int k = 0; k < kStages; ++k) {
      A.push_back(MatrixXd::Identity(kNdx, kNdx) + matrix(kNdx, kNdx, 0.1));
      B.push_back(matrix(kNdx, kNu, 0.3));
      lu.push_back(matrix(kNu, 1, 0.1));
      F.push_back(matrix(kNdx, 1, 0.2));
    }
    for (int k = 0; k <= kStages; ++k) lx.push_back(matrix(kNdx, 1, 1.0));
    fill();
  }

  void fill() {
    for (int k = 0; k <= kStages; ++k) {
      for (int i = 0; i < kNdx; ++i) costs[k].lx[i] = lx[k][i], costs[k].lxx_diagonal[i] = W(i, i);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) costs[k].lxx_theta[i][j] = W(kTheta + i, kTheta + j);
      if (k == kStages) break;
      for (int i = 0; i < kNu; ++i) costs[k].lu[i] = lu[k][i], costs[k].luu_diagonal[i] = R(i, i);
      for (int i = 0; i < kNdx; ++i) {
        derivatives[k].F[i] = F[k][i];
        for (int j = 0; j < kColumns; ++j)
          derivatives[k].AB[i][j] = j < kNdx ? A[k](i, j) : B[k](i, j - kNdx);
      }
    }
  }
  BackwardInput input(double sigma, double mu = 0, bool one_channel = false) const {
    BackwardInput in;
    in.stages = kStages, in.derivatives = derivatives.get(), in.costs = costs.get(), in.u = u;
    in.input_limit_rad = 1.0, in.sigma = sigma, in.mu = mu;
    in.one_noise_channel = one_channel;
    return in;
  }
};

/// Noise columns of a linear problem, in the solver's layout and in Eigen's.
struct LinearColumns {
  std::vector<StageNoise> stages{LinearProblem::kStages};
  std::vector<std::vector<MatrixXd>> D;  // [stage][column] 36 x 48
  std::vector<std::vector<VectorXd>> c;
  NoiseColumns columns;

  /// `count` random columns; every second one with a channel a coordinate.
  LinearColumns(unsigned seed, int count)
      : D(stages.size(), std::vector<MatrixXd>(static_cast<std::size_t>(count))),
        c(stages.size(), std::vector<VectorXd>(static_cast<std::size_t>(count))) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    columns.count = count;
    for (int e = 0; e < count; ++e)
      columns.variance[e] = 0.3 + 0.2 * e, columns.by_coordinate[e] = e % 2 == 1;
    const auto matrix = [&](int cols, double size) {
      return MatrixXd(MatrixXd::NullaryExpr(kNdx, cols, [&] { return size * normal(random); }));
    };
    for (std::size_t k = 0; k < stages.size(); ++k)
      for (int e = 0; e < count; ++e) {
        const auto at = static_cast<std::size_t>(e);
        D[k][at] = matrix(kColumns, 0.1), c[k][at] = matrix(1, 0.2);
        fill(D[k][at], c[k][at], stages[k].column[e]);
      }
    columns.stage = stages.data();
  }
  static void fill(const MatrixXd& D, const VectorXd& c, NoiseColumn& out) {
    for (int i = 0; i < kNdx; ++i) {
      out.c[i] = c[i];
      for (int j = 0; j < kColumns; ++j) out.D[i][j] = D(i, j);
    }
  }
  /// Sum of variance [c | D]' W [c | D] under the value V: at, slope and curvature in one matrix.
  MatrixXd price(std::size_t stage, const MatrixXd& V) const {
    MatrixXd sum = MatrixXd::Zero(1 + kColumns, 1 + kColumns);
    for (std::size_t e = 0; e < D[stage].size(); ++e) {
      const MatrixXd W = columns.by_coordinate[e] ? MatrixXd(V.diagonal().asDiagonal()) : V;
      MatrixXd all(kNdx, 1 + kColumns);
      all << c[stage][e], D[stage][e];
      sum += columns.variance[e] * all.transpose() * W * all;
    }
    return sum;
  }
};

struct Pass {
  std::unique_ptr<StageGains[]> gains{new StageGains[kMaxStages]};
  std::unique_ptr<NoisePrice[]> noise{new NoisePrice[kMaxStages]};
  std::unique_ptr<ColumnsPrice[]> columns{new ColumnsPrice[kMaxStages]};
  std::unique_ptr<Value> value{new Value};
  BackwardSummary summary;
  Pass(BackwardPassFn run, const BackwardInput& in) {
    summary = run(in, {gains.get(), noise.get(), columns.get()}, *value);
  }
  double price(int k, const VectorXd& du) const {
    const NoisePrice& n = noise[k];
    double sum = n.still;
    for (int i = 0; i < kNu; ++i) {
      sum += 2 * n.slope[i] * du[i];
      for (int j = 0; j < kNu; ++j) sum += du[i] * n.curvature[i][j] * du[j];
    }
    return sum;
  }
  double gain_norm(int k) const {
    double sum = 0;
    for (const auto& row : gains[k].K)
      for (int j = 0; j < kNdx; ++j) sum += row[j] * row[j];
    return std::sqrt(sum);
  }
};

struct NamedPass {
  const char* name;
  BackwardPassFn run;
};
std::vector<NamedPass> passes() {
  const LaneKernels* all[3];
  std::vector<NamedPass> out;
  out.reserve(3);
  for (int i = 0; i < available_lane_kernels(all, 3); ++i)
    out.push_back({all[i]->name, all[i]->backward_pass});
  return out;
}

void expect_gains(const StageGains& gains, const MatrixXd& K, const VectorXd& k) {
  for (int i = 0; i < kNu; ++i) {
    EXPECT_NEAR(gains.k[i], k[i], 1e-9 * k.norm());
    for (int j = 0; j < kNdx; ++j) ASSERT_NEAR(gains.K[i][j], K(i, j), 1e-9 * K.norm());
  }
}

TEST(BackwardPass, EqualsRiccatiWithMultiplicativeNoise) {
  for (unsigned seed = 1; seed <= 4; ++seed)
    for (const double sigma : {0.0, 0.7})
      for (const auto& pass : passes()) {
        const bool one = seed % 2 == 0;  // a single channel, or one for every coordinate
        SCOPED_TRACE(std::string(pass.name) + " seed " + std::to_string(seed) + " sigma " +
                     std::to_string(sigma));
        const LinearProblem p(seed);
        const Pass result(pass.run, p.input(sigma, 0, one));
        ASSERT_TRUE(result.summary.ok);
        // textbook recursion, dense, general linear solve
        MatrixXd V = p.W;
        VectorXd v = p.lx[LinearProblem::kStages];
        for (int k = LinearProblem::kStages - 1; k >= 0; --k) {
          const MatrixXd D = one ? V : MatrixXd(V.diagonal().asDiagonal());
          const MatrixXd Quu = p.R + p.B[k].transpose() * (V + sigma * sigma * D) * p.B[k];
          const VectorXd du = VectorXd::LinSpaced(kNu, -0.3, 0.2), F = p.F[k] + p.B[k] * du;
          const double price = sigma * sigma * F.dot(D * F);
          EXPECT_NEAR(result.price(k, du), price, 1e-9 * price);
          const VectorXd Qu = p.lu[k] + p.B[k].transpose() * (v + sigma * sigma * D * p.F[k]);
          const MatrixXd Qux = p.B[k].transpose() * V * p.A[k];
          const MatrixXd K = -Quu.partialPivLu().solve(Qux);
          const VectorXd ff = -Quu.partialPivLu().solve(Qu);
          ASSERT_NO_FATAL_FAILURE(expect_gains(result.gains[k], K, ff));
          v = p.lx[k] + p.A[k].transpose() * v + K.transpose() * Quu * ff + K.transpose() * Qu +
              Qux.transpose() * ff;
          V = p.W + p.A[k].transpose() * V * p.A[k] + K.transpose() * Quu * K +
              K.transpose() * Qux + Qux.transpose() * K;
        }
        for (int i = 0; i < kNdx; ++i) {
          EXPECT_NEAR(result.value->Vx[i], v[i], 1e-9 * v.norm());
          for (int j = 0; j < kNdx; ++j)
            ASSERT_NEAR(result.value->Vxx[i][j], V(i, j), 1e-9 * V.norm());
        }
      }
}

TEST(BackwardPass, EqualsRiccatiWithNoiseThatHasSlopes) {
  for (const auto& pass : passes()) {
    SCOPED_TRACE(pass.name);
    const LinearProblem p(11);
    const LinearColumns noise(12, 3);
    BackwardInput in = p.input(0.0);
    in.columns = &noise.columns;
    const Pass result(pass.run, in);
    ASSERT_TRUE(result.summary.ok);
    MatrixXd V = p.W;
    VectorXd v = p.lx[LinearProblem::kStages];
    for (int k = LinearProblem::kStages - 1; k >= 0; --k) {
      const MatrixXd priced = noise.price(static_cast<std::size_t>(k), V);
      const ColumnsPrice& out = result.columns[k];
      ASSERT_NEAR(out.at, priced(0, 0), 1e-9 * priced.norm());
      for (int i = 0; i < kColumns; ++i) {
        ASSERT_NEAR(out.slope[i], priced(0, 1 + i), 1e-9 * priced.norm());
        for (int j = 0; j < kColumns; ++j)
          ASSERT_NEAR(out.curvature[i][j], priced(1 + i, 1 + j), 1e-9 * priced.norm());
      }
      MatrixXd AB(kNdx, kColumns);
      AB << p.A[k], p.B[k];
      MatrixXd Q = AB.transpose() * V * AB + priced.bottomRightCorner(kColumns, kColumns);
      Q.topLeftCorner(kNdx, kNdx) += p.W;
      Q.bottomRightCorner(kNu, kNu) += p.R;
      VectorXd q = AB.transpose() * v + priced.col(0).tail(kColumns);
      q.head(kNdx) += p.lx[k];
      q.tail(kNu) += p.lu[k];
      const MatrixXd Quu = Q.bottomRightCorner(kNu, kNu), Qux = Q.bottomLeftCorner(kNu, kNdx);
      const VectorXd Qu = q.tail(kNu);
      const MatrixXd K = -Quu.partialPivLu().solve(Qux);
      const VectorXd ff = -Quu.partialPivLu().solve(Qu);
      ASSERT_NO_FATAL_FAILURE(expect_gains(result.gains[k], K, ff));
      v = q.head(kNdx) + K.transpose() * Qu;
      V = Q.topLeftCorner(kNdx, kNdx) + Qux.transpose() * K;
    }
  }
}

TEST(BackwardPass, AColumnThatFollowsTheInputIsTheNoiseThatInputsMake) {
  const LinearProblem p(13);
  const double sigma = 0.7;
  LinearColumns noise(14, 1);
  for (int k = 0; k < LinearProblem::kStages; ++k) {
    MatrixXd D = MatrixXd::Zero(kNdx, kColumns);
    D.rightCols(kNu) = p.B[k];
    LinearColumns::fill(D, p.F[k], noise.stages[static_cast<std::size_t>(k)].column[0]);
  }
  noise.columns.variance[0] = sigma * sigma;
  for (const bool one : {false, true}) {
    noise.columns.by_coordinate[0] = !one;
    BackwardInput in = p.input(0.0);
    in.columns = &noise.columns;
    const Pass columns(lane_kernels().backward_pass, in),
        input(lane_kernels().backward_pass, p.input(sigma, 0, one));
    for (int k = 0; k < LinearProblem::kStages; ++k)
      for (int i = 0; i < kNu; ++i) {
        EXPECT_NEAR(columns.gains[k].k[i], input.gains[k].k[i], 1e-9);
        for (int j = 0; j < kNdx; ++j)
          ASSERT_NEAR(columns.gains[k].K[i][j], input.gains[k].K[i][j], 1e-9);
      }
  }
}

TEST(BackwardPass, RegularizationKeepsTheValueOfTheRegularizedPolicy) {
  // with mu the gains are not optimal; Vxx must still be the cost-to-go of exactly those gains
  const LinearProblem p(4);
  const double mu = 2.0;
  for (const auto& pass : passes()) {
    SCOPED_TRACE(pass.name);
    const Pass result(pass.run, p.input(0.3, mu));
    MatrixXd V = p.W;
    for (int k = LinearProblem::kStages - 1; k >= 0; --k) {
      MatrixXd K(kNu, kNdx);
      for (int i = 0; i < kNu; ++i)
        for (int j = 0; j < kNdx; ++j) K(i, j) = result.gains[k].K[i][j];
      const MatrixXd D = V.diagonal().asDiagonal();
      const MatrixXd closed = p.A[k] + p.B[k] * K;
      V = p.W + closed.transpose() * V * closed +
          K.transpose() * (p.R + 0.09 * p.B[k].transpose() * D * p.B[k]) * K;
    }
    for (int i = 0; i < kNdx; ++i)
      for (int j = 0; j < kNdx; ++j) ASSERT_NEAR(result.value->Vxx[i][j], V(i, j), 1e-9 * V.norm());
  }
}

TEST(BackwardPass, NoiseShrinksGainsAndRaisesTheCostOfUsingInput) {
  LinearProblem p(5);
  for (VectorXd& F : p.F) F.setZero();  // a cold start: without input there is no noise yet
  p.fill();
  double last_norm = 1e9, last_gain = -1e9;
  for (const double sigma : {0.0, 0.1, 0.7, 2.0}) {
    const Pass result(lane_kernels().backward_pass, p.input(sigma));
    double norm = 0;
    for (int k = 0; k < LinearProblem::kStages; ++k) norm += result.gain_norm(k);
    EXPECT_LT(norm, last_norm) << "sigma " << sigma;
    last_norm = norm;
    // the promised decrease of cost (negative) becomes smaller in size
    const double promised = result.summary.linear + result.summary.quadratic;
    EXPECT_GT(promised, last_gain) << "sigma " << sigma;
    last_gain = promised;
  }
}

TEST(BackwardPass, AnInputPushedAgainstItsLimitIsHeld) {
  LinearProblem p(6);
  const Pass freely(lane_kernels().backward_pass, p.input(0.0));
  const int j = 5;
  p.u[10][j] = freely.gains[10].k[j] > 0 ? 1.0 : -1.0;  // at the limit it wants to cross
  const Pass held(lane_kernels().backward_pass, p.input(0.0));
  EXPECT_EQ(held.gains[10].k[j], 0.0);
  for (int i = 0; i < kNdx; ++i) EXPECT_EQ(held.gains[10].K[j][i], 0.0);
  EXPECT_NE(held.gains[10].k[(j + 1) % kNu], 0.0);
}

TEST(BackwardPass, RefusesWhatIsNotFinite) {
  LinearProblem p(7);
  p.derivatives[3].AB[2][40] = std::nan("");
  for (const auto& pass : passes())
    EXPECT_FALSE(Pass(pass.run, p.input(0.1)).summary.ok) << pass.name;
}

TEST(BackwardPass, SummaryPredictsTheChangeOfCost) {
  // on a linear problem the cost along alpha is exactly quadratic: checked by rolling the linear
  // system out
  const LinearProblem p(8);
  const Pass result(lane_kernels().backward_pass, p.input(0.0));
  const auto cost = [&](double alpha) {
    VectorXd dx = VectorXd::Zero(kNdx);
    double sum = 0;
    for (int k = 0; k <= LinearProblem::kStages; ++k) {
      sum += p.lx[k].dot(dx) + 0.5 * dx.dot(p.W * dx);
      if (k == LinearProblem::kStages) break;
      VectorXd du(kNu);
      for (int i = 0; i < kNu; ++i) {
        du[i] = alpha * result.gains[k].k[i];
        for (int j = 0; j < kNdx; ++j) du[i] += result.gains[k].K[i][j] * dx[j];
      }
      sum += p.lu[k].dot(du) + 0.5 * du.dot(p.R * du);
      dx = p.A[k] * dx + p.B[k] * du;
    }
    return sum;
  };
  for (const double alpha : {0.25, 1.0})
    EXPECT_NEAR(cost(alpha),
                alpha * result.summary.linear + alpha * alpha * result.summary.quadratic, 1e-9);
}

}  // namespace
}  // namespace sanso::mpc
