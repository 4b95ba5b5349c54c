// Active sets: solve for the free unknowns; the first that would leave its bounds is held there;
// when all are inside, the held one that wants back most is freed.
#include "tools/diagnose/torque/bounded_least_squares.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

namespace sanso::diagnose {
namespace {

// of an unknown's own curvature: keeps twins apart, moves nothing that data determine
constexpr double kRidge = 1e-9;

struct Problem {
  const Eigen::MatrixXd& G;
  const Eigen::VectorXd& c;
  const Eigen::VectorXd& low;
  const Eigen::VectorXd& high;
  double ridge(Eigen::Index i) const { return kRidge * G(i, i) + 1e-300; }
};

/// The free unknowns' optimum while the others stay; in the order of `free`.
Eigen::VectorXd solve_free(const Problem& p, const std::vector<Eigen::Index>& free,
                           const std::vector<char>& is_free, const Eigen::VectorXd& x) {
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd G(n, n);
  Eigen::VectorXd c(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const Eigen::Index i = free[static_cast<std::size_t>(a)];
    for (Eigen::Index b = 0; b < n; ++b) G(a, b) = p.G(i, free[static_cast<std::size_t>(b)]);
    G(a, a) += p.ridge(i);
    c[a] = p.c[i];
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      if (is_free[static_cast<std::size_t>(k)] == 0) c[a] -= p.G(i, k) * x[k];
    }
  }
  return G.ldlt().solve(c);
}

/// The held unknown whose gradient pulls it inside most, in its own scale; -1: none.
Eigen::Index wants_back(const Problem& p, const std::vector<char>& is_free,
                        const Eigen::VectorXd& x) {
  Eigen::Index best = -1;
  double most = 1e-9;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    if (is_free[static_cast<std::size_t>(i)] != 0 || !(p.low[i] < p.high[i])) continue;
    const double slope = p.G.row(i).dot(x) - p.c[i];
    const double scale = std::abs(p.c[i]) + std::abs(p.G(i, i)) + 1e-300;
    const double pull = (x[i] <= p.low[i] ? -slope : slope) / scale;
    if (pull > most) most = pull, best = i;
  }
  return best;
}

}  // namespace

Eigen::VectorXd bounded_least_squares(const Eigen::MatrixXd& G, const Eigen::VectorXd& c,
                                      const Eigen::VectorXd& low, const Eigen::VectorXd& high) {
  const Problem p{G, c, low, high};
  const Eigen::Index n = c.size();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n).cwiseMax(low).cwiseMin(high);
  std::vector<char> is_free(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i)
    is_free[static_cast<std::size_t>(i)] = p.low[i] < p.high[i] && G(i, i) > 0.0 ? 1 : 0;
  for (Eigen::Index round = 0; round < 20 * n + 20; ++round) {
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < n; ++i) {
      if (is_free[static_cast<std::size_t>(i)] != 0) free.push_back(i);
    }
    const Eigen::VectorXd z = solve_free(p, free, is_free, x);
    double step = 1.0;
    Eigen::Index hit = -1;
    for (std::size_t a = 0; a < free.size(); ++a) {
      const Eigen::Index i = free[a];
      const double to = z[static_cast<Eigen::Index>(a)];
      const double bound = to < low[i] ? low[i] : high[i];
      if (to >= low[i] && to <= high[i]) continue;
      const double share = std::clamp((bound - x[i]) / (to - x[i]), 0.0, 1.0);
      if (hit < 0 || share < step) step = share, hit = i;
    }
    for (std::size_t a = 0; a < free.size(); ++a)
      x[free[a]] += step * (z[static_cast<Eigen::Index>(a)] - x[free[a]]);
    if (hit >= 0) {
      x[hit] = std::abs(x[hit] - low[hit]) < std::abs(x[hit] - high[hit]) ? low[hit] : high[hit];
      is_free[static_cast<std::size_t>(hit)] = 0;
      continue;
    }
    const Eigen::Index back = wants_back(p, is_free, x);
    if (back < 0 || !(G(back, back) > 0.0)) break;
    is_free[static_cast<std::size_t>(back)] = 1;
  }
  return x;
}

}  // namespace sanso::diagnose
