// Plain iLQG by dense algebra and central differences; slow on purpose, and stopped by the same
// rule as the product's solver.
#include "tests/host/mpc/support/reference_model.h"

#include <cmath>

namespace sanso::mpc::reference {
namespace {

using Matrix = Eigen::Matrix<double, model::kNdx, model::kNdx>;
using model::Gain;
using model::Input;
using model::State;
using model::Tangent;

struct Quadratic {
  Tangent gradient;
  Matrix hessian;
};

// Gauss-Newton model of the state cost at x, by differences of the error vector.
Quadratic state_cost_model(const Model& m, int knot, const State& x) {
  const State ref = Eigen::Map<const State>(m.context().x_ref[knot]);
  const Tangent e = model::minus(x, ref);
  Matrix J;
  constexpr double h = 1e-6;
  for (int i = 0; i < kNdx; ++i)
    J.col(i) = (model::minus(model::plus(x, h * Tangent::Unit(i)), ref) -
                model::minus(model::plus(x, -h * Tangent::Unit(i)), ref)) /
               (2 * h);
  const Eigen::Map<const Tangent> w(m.context().state_weight);
  return {2 * J.transpose() * w.cwiseProduct(e), 2 * J.transpose() * w.asDiagonal() * J};
}

Input clamped(const Input& u, double limit) { return u.cwiseMax(-limit).cwiseMin(limit); }

double total_cost(const Model& m, const Solution& s) {
  double sum = 0;
  for (std::size_t k = 0; k < s.x.size(); ++k) sum += m.cost(static_cast<int>(k), s.x[k]);
  for (const Input& u : s.u) sum += m.cost(u);
  return sum;
}

Solution roll_out(const Model& m, const Solution& nominal, const std::vector<Input>& k,
                  const std::vector<Gain>& K, double alpha, double limit) {
  Solution s = nominal;
  for (std::size_t i = 0; i < nominal.u.size(); ++i) {
    s.u[i] =
        clamped(nominal.u[i] + alpha * k[i] + K[i] * model::minus(s.x[i], nominal.x[i]), limit);
    s.x[i + 1] = m.step(static_cast<int>(i), s.x[i], s.u[i]);
  }
  s.cost = total_cost(m, s);
  return s;
}

void backward(const Model& m, const Solution& s, double mu, std::vector<Input>& k,
              std::vector<Gain>& K) {
  const int stages = static_cast<int>(s.u.size());
  Quadratic V = state_cost_model(m, stages, s.x.back());
  const Eigen::Map<const Input> wu(m.context().input_weight);
  for (int i = stages - 1; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    const Jacobian AB = m.central_differences(i, s.x[at], s.u[at], 1e-5);
    const auto A = AB.leftCols<model::kNdx>();
    const auto B = AB.rightCols<model::kNu>();
    const Quadratic l = state_cost_model(m, i, s.x[at]);
    const Tangent Qx = l.gradient + A.transpose() * V.gradient;
    const Input Qu = 2 * wu.cwiseProduct(s.u[at]) + B.transpose() * V.gradient;
    const Matrix Qxx = l.hessian + A.transpose() * V.hessian * A;
    Eigen::Matrix<double, model::kNu, model::kNu> Quu = B.transpose() * V.hessian * B;
    Quu.diagonal() += 2 * wu;
    const Gain Qux = B.transpose() * V.hessian * A;
    auto regular = Quu;
    regular.diagonal().array() += mu;
    const auto solver = regular.ldlt();
    k[at] = -solver.solve(Qu);
    K[at] = -solver.solve(Qux);
    V.gradient = Qx + K[at].transpose() * (Quu * k[at] + Qu) + Qux.transpose() * k[at];
    V.hessian =
        Qxx + K[at].transpose() * Quu * K[at] + K[at].transpose() * Qux + Qux.transpose() * K[at];
    V.hessian = (0.5 * (V.hessian + V.hessian.transpose())).eval();
  }
}

}  // namespace

Solution solve(const Model& m, int stages, const State& x0, double limit, int max_iterations) {
  Solution s;
  s.x.assign(static_cast<std::size_t>(stages) + 1, x0);
  s.u.assign(static_cast<std::size_t>(stages), Input::Zero());
  std::vector<Input> k(s.u.size(), Input::Zero());
  std::vector<Gain> K(s.u.size(), Gain::Zero());
  s = roll_out(m, s, k, K, 0, limit);
  std::vector<double> costs{s.cost};
  double mu = 0;
  for (s.iterations = 0; s.iterations < max_iterations;) {
    backward(m, s, mu, k, K);
    Solution best = s;
    for (double alpha = 1.0; alpha > 1e-3; alpha *= 0.7) {
      const Solution tried = roll_out(m, s, k, K, alpha, limit);
      if (tried.cost < best.cost) best = tried;
    }
    const double gain = s.cost - best.cost;
    best.iterations = ++s.iterations;
    if (gain < 1e-6 * s.cost) {
      if (mu > 1) break;
      mu = std::max(1e-2, 100 * mu);
    } else {
      mu *= 0.01;
    }
    s = best;
    costs.push_back(s.cost);
  }
  s.costs = costs;
  return s;
}

double Solution::cost_stopped(double convergence, int max_iterations) const {
  for (std::size_t i = 1; i < costs.size(); ++i)
    if (static_cast<int>(i) == max_iterations ||
        costs[i - 1] - costs[i] < convergence * costs[i - 1])
      return costs[i];
  return costs.back();
}

double closed_loop_cost(const Model& m, const State& x0, const std::vector<State>& x,
                        const std::vector<Input>& u, const std::vector<Gain>& K, double limit) {
  Solution nominal;
  nominal.x = x;
  nominal.x[0] = x0;
  nominal.u = u;
  Solution s = nominal;
  for (std::size_t i = 0; i < u.size(); ++i) {
    s.u[i] = clamped(u[i] + K[i] * model::minus(s.x[i], x[i]), limit);
    s.x[i + 1] = m.step(static_cast<int>(i), s.x[i], s.u[i]);
  }
  return total_cost(m, s);
}

}  // namespace sanso::mpc::reference
