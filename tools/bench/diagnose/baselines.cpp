#include "tools/bench/diagnose/baselines.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace sanso::bench {
namespace {

using diagnose::FirstLook;

constexpr double kRidge =
    1e-3;  // keeps probes of the same effect, which are nearly alike, from making the matrix singular
constexpr int kLargestModel = 6;

Eigen::MatrixXd correlation_of(const FirstLook& look) {
  const auto n = static_cast<Eigen::Index>(look.z.size());
  return Eigen::Map<const Eigen::MatrixXd>(look.correlation.data(), n, n);
}

void add(Names& names, const std::string& effect) {
  if (std::find(names.begin(), names.end(), effect) == names.end()) names.push_back(effect);
}

/// Amounts of the chosen probes, in units of their standard deviations, and what is left of all scores.
Eigen::VectorXd left_after(const Eigen::MatrixXd& C, const Eigen::VectorXd& z,
                           const std::vector<Eigen::Index>& chosen) {
  const auto m = static_cast<Eigen::Index>(chosen.size());
  if (m == 0) return z;
  Eigen::MatrixXd H(m, m), cross(z.size(), m);
  Eigen::VectorXd b(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const Eigen::Index c = chosen[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < m; ++j) H(i, j) = C(c, chosen[static_cast<std::size_t>(j)]) + (i == j ? kRidge : 0.0);
    cross.col(i) = C.col(c);
    b[i] = z[c];
  }
  return z - cross * H.ldlt().solve(b);
}

Names pursue(const FirstLook& look, const std::string& only_family) {
  const Eigen::MatrixXd C = correlation_of(look);
  const auto n = static_cast<Eigen::Index>(look.z.size());
  const Eigen::VectorXd z = Eigen::Map<const Eigen::VectorXd>(look.z.data(), n);
  std::vector<Eigen::Index> chosen;
  Names names;
  while (static_cast<int>(names.size()) < kLargestModel) {
    const Eigen::VectorXd left = left_after(C, z, chosen);
    Eigen::Index best = -1;
    for (Eigen::Index i = 0; i < n; ++i) {
      const bool allowed = only_family.empty() || look.family[static_cast<std::size_t>(i)] == only_family;
      if (allowed && (best < 0 || std::abs(left[i]) > std::abs(left[best]))) best = i;
    }
    const bool stops = best < 0 || std::abs(left[best]) < look.critical ||
                       std::find(chosen.begin(), chosen.end(), best) != chosen.end();
    if (stops) break;
    chosen.push_back(best);
    add(names, look.effect[static_cast<std::size_t>(best)]);
  }
  return names;
}

}  // namespace

Names largest_score(const FirstLook& look) {
  const auto best =
      std::max_element(look.z.begin(), look.z.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  if (best == look.z.end() || std::abs(*best) < look.critical) return {};
  return {look.effect[static_cast<std::size_t>(best - look.z.begin())]};
}

Names fit_everything(const FirstLook& look) {
  const auto n = static_cast<Eigen::Index>(look.z.size());
  Eigen::MatrixXd C = correlation_of(look);
  C.diagonal().array() += kRidge;
  const Eigen::LDLT<Eigen::MatrixXd> factor = C.ldlt();
  const Eigen::VectorXd amount = factor.solve(Eigen::Map<const Eigen::VectorXd>(look.z.data(), n));
  const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(n, n));
  std::vector<std::pair<double, std::string>> sure;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = std::abs(amount[i]) / std::sqrt(std::max(inverse(i, i), 1e-12));
    if (t > 3.0) sure.emplace_back(-t, look.effect[static_cast<std::size_t>(i)]);
  }
  std::sort(sure.begin(), sure.end());
  Names names;
  for (const auto& [t, effect] : sure) add(names, effect);
  return names;
}

Names sparse_regression(const FirstLook& look) { return pursue(look, ""); }
Names friction_ladder(const FirstLook& look) { return pursue(look, "friction"); }

}  // namespace sanso::bench
