// Greedy pursuit, largest score, thresholds and sparse regression on one Gram matrix; each
// returns the effects that it names.
#include "tools/bench/diagnose/baselines.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace sanso::bench {
namespace {

using diagnose::FirstLook;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kLargestModel = 6;
/// Of a probe's own energy: keeps probes of the same effect, which are nearly alike, from making a
/// matrix singular.
constexpr double kRidge = 1e-4;

/// Inner products of [nuisances | probes | error] over some of the groups.
class Gram {
 public:
  Gram(const FirstLook& look, MatrixXd G)
      : nuisances_(look.nuisances), precision_(look.nuisance_precision), G_(std::move(G)) {}
  Index probes() const { return G_.cols() - nuisances_ - 1; }
  Index error() const { return G_.cols() - 1; }

  /// Columns of a model: all nuisances and the chosen probes.
  std::vector<Index> columns(const std::vector<Index>& chosen) const {
    std::vector<Index> out(static_cast<std::size_t>(nuisances_));
    std::iota(out.begin(), out.end(), Index{0});
    for (const Index probe : chosen) out.push_back(nuisances_ + probe);
    return out;
  }
  /// Normal matrix with the nuisances' prior and the probes' ridge.
  MatrixXd normal(const std::vector<Index>& at) const {
    MatrixXd H = G_(at, at);
    for (Index i = 0; i < H.rows(); ++i)
      H(i, i) += i < nuisances_ ? precision_ : kRidge * H(i, i) + 1e-9;
    return H;
  }
  VectorXd fit(const std::vector<Index>& at) const {
    return -normal(at).ldlt().solve(VectorXd(G_(at, error())));
  }
  /// |error + columns x|^2
  double energy(const std::vector<Index>& at, const VectorXd& x) const {
    const VectorXd b = G_(at, error());
    return G_(error(), error()) + 2.0 * x.dot(b) + x.dot(MatrixXd(G_(at, at)) * x);
  }
  /// Score of every probe beside a fitted model: gain of one more column, as far as its own energy
  /// goes.
  VectorXd scores(const std::vector<Index>& at, const VectorXd& x) const {
    VectorXd out(probes());
    for (Index i = 0; i < probes(); ++i) {
      const Index c = nuisances_ + i;
      const double left = G_(c, error()) + VectorXd(G_(at, c)).dot(x);
      out[i] = left * left / std::max(G_(c, c), 1e-12);
    }
    return out;
  }
  Index nuisances() const { return nuisances_; }

 private:
  Index nuisances_;
  double precision_;
  MatrixXd G_;
};

/// Every group but `left_out` (-1: all).
Gram sum(const FirstLook& look, int left_out) {
  MatrixXd total = MatrixXd::Zero(look.by_group.front().rows(), look.by_group.front().cols());
  for (std::size_t g = 0; g < look.by_group.size(); ++g) {
    if (static_cast<int>(g) != left_out) total += look.by_group[g];
  }
  return {look, std::move(total)};
}

/// Models of growing size, fitted to a part of the data: path[k] are the probes of model k; path[0]
/// is empty.
using Path = std::vector<std::vector<Index>>;
using MakePath = std::function<Path(const Gram&)>;

/// The size that predicts the groups left out best, by the one-standard-error rule: the smallest
/// that is not worse than the best by more than the standard error of their difference over groups.
/// The path is made without the group, too.
std::size_t held_out_size(const FirstLook& look, const MakePath& make_path) {
  const std::size_t groups = look.by_group.size();
  if (groups < 2) return 0;
  std::vector<std::vector<double>> energy(groups);  // by group, by size
  std::size_t sizes = kLargestModel + 1;
  for (std::size_t g = 0; g < groups; ++g) {
    const Gram train = sum(look, static_cast<int>(g)), test(look, look.by_group[g]);
    for (const std::vector<Index>& model : make_path(train)) {
      const std::vector<Index> at = train.columns(model);
      energy[g].push_back(test.energy(at, train.fit(at)));
    }
    sizes = std::min(sizes, energy[g].size());
  }
  const auto total = [&](std::size_t k) {
    return std::accumulate(energy.begin(), energy.end(), 0.0,
                           [k](double sum, const std::vector<double>& e) { return sum + e[k]; });
  };
  std::size_t best = 0;
  for (std::size_t k = 1; k < sizes; ++k) {
    if (total(k) < total(best)) best = k;
  }
  for (std::size_t k = 0; k < best; ++k) {
    double mean = 0.0, square = 0.0;
    const auto n = static_cast<double>(groups);
    for (const std::vector<double>& e : energy) mean += (e[k] - e[best]) / n;
    for (const std::vector<double>& e : energy)
      square += (e[k] - e[best] - mean) * (e[k] - e[best] - mean);
    if (n * mean <= std::sqrt(n * square / (n - 1.0))) return k;
  }
  return best;
}

Names names_of(const FirstLook& look, const std::vector<Index>& probes) {
  Names names;
  for (const Index probe : probes) {
    const std::string& effect = look.effect[static_cast<std::size_t>(probe)];
    if (std::find(names.begin(), names.end(), effect) == names.end()) names.push_back(effect);
  }
  return names;
}

Names select(const FirstLook& look, const MakePath& make_path) {
  if (look.by_group.empty() || look.effect.empty()) return {};
  const Path path = make_path(sum(look, -1));
  return names_of(look, path[std::min(held_out_size(look, make_path), path.size() - 1)]);
}

/// Orthogonal matching pursuit among the allowed probes.
Path pursuit(const Gram& gram, std::size_t largest, const std::function<bool(Index)>& allowed) {
  Path path{{}};
  while (path.size() <= largest) {
    std::vector<Index> chosen = path.back();
    const std::vector<Index> at = gram.columns(chosen);
    const VectorXd scores = gram.scores(at, gram.fit(at));
    Index best = -1;
    for (Index i = 0; i < scores.size(); ++i) {
      const bool open = allowed(i) && std::find(chosen.begin(), chosen.end(), i) == chosen.end();
      if (open && (best < 0 || scores[i] > scores[best])) best = i;
    }
    if (best < 0) break;
    chosen.push_back(best);
    path.push_back(std::move(chosen));
  }
  return path;
}

/// Everything fitted; model k keeps the probes whose t is above the k-th threshold, from none to
/// all above 3.
Path above_thresholds(const Gram& gram) {
  std::vector<Index> all(static_cast<std::size_t>(gram.probes()));
  std::iota(all.begin(), all.end(), Index{0});
  const std::vector<Index> at = gram.columns(all);
  const Eigen::LDLT<MatrixXd> factor = gram.normal(at).ldlt();
  const VectorXd x = gram.fit(at);
  const MatrixXd inverse = factor.solve(MatrixXd::Identity(x.size(), x.size()));
  std::vector<std::pair<double, Index>> order;
  for (const Index i : all) {
    const Index c = gram.nuisances() + i;
    order.emplace_back(-std::abs(x[c]) / std::sqrt(std::max(inverse(c, c), 1e-12)), i);
  }
  std::sort(order.begin(), order.end());
  Path path{{}};
  for (const double threshold : {100.0, 50.0, 20.0, 10.0, 5.0, 3.0}) {
    std::vector<Index> kept;
    for (const auto& entry : order) {
      if (-entry.first > threshold) kept.push_back(entry.second);
    }
    path.push_back(std::move(kept));
  }
  return path;
}

}  // namespace

Names largest_score(const FirstLook& look) {
  return select(look,
                [](const Gram& gram) { return pursuit(gram, 1, [](Index) { return true; }); });
}

Names fit_everything(const FirstLook& look) { return select(look, above_thresholds); }

Names sparse_regression(const FirstLook& look) {
  return select(look, [](const Gram& gram) {
    return pursuit(gram, kLargestModel, [](Index) { return true; });
  });
}

Names friction_ladder(const FirstLook& look) {
  const auto friction = [&look](Index i) {
    return look.family[static_cast<std::size_t>(i)] == diagnose::Family::friction;
  };
  return select(look, [&](const Gram& gram) { return pursuit(gram, kLargestModel, friction); });
}

}  // namespace sanso::bench
