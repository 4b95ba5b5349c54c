// Own normal numbers (Box and Muller), so that a seed gives the same samples with every standard
// library; a loss that is no number ranks last.
#include "host/learn/model/cross_entropy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

#include "host/learn/seeds.h"

namespace sanso::learn {
namespace {

double ranked(double loss) {
  return std::isfinite(loss) ? loss : std::numeric_limits<double>::infinity();
}

// Box and Muller's method on 53-bit uniforms: the same numbers with every standard library.
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : rng_(seed) {}
  double operator()() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform())),
                 angle = 2.0 * M_PI * uniform();
    return radius * std::cos(angle);
  }

 private:
  double uniform() { return static_cast<double>(rng_() >> 11) * 0x1.0p-53; }
  std::mt19937_64 rng_;
};

Eigen::MatrixXd samples_of(const CrossEntropyState& state, int population, std::uint64_t seed) {
  Normal normal(
      derived_seed(seed, static_cast<std::uint64_t>(state.generation), Stream::identification));
  Eigen::MatrixXd candidates(state.mean.size(), population);
  for (Eigen::Index c = 0; c < population; ++c) {
    for (Eigen::Index i = 0; i < state.mean.size(); ++i)
      candidates(i, c) = state.mean[i] + state.deviation[i] * normal();
  }
  return candidates;
}

}  // namespace

CrossEntropyState start_cross_entropy(const Eigen::VectorXd& mean, const Eigen::VectorXd& deviation,
                                      const EvaluateCandidates& evaluate) {
  if (mean.size() == 0 || mean.size() != deviation.size())
    throw std::invalid_argument(
        "cross-entropy: mean and deviation must have the same, non-zero size");
  return {0, mean, deviation, mean, ranked(evaluate(mean).at(0))};
}

void advance_cross_entropy(CrossEntropyState& state, const CrossEntropySettings& settings,
                           std::uint64_t seed, const EvaluateCandidates& evaluate) {
  const Eigen::MatrixXd candidates = samples_of(state, settings.population, seed);
  std::vector<double> losses = evaluate(candidates);
  std::transform(losses.begin(), losses.end(), losses.begin(), ranked);

  std::vector<Eigen::Index> order(losses.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return losses[a] < losses[b]; });
  const int elites = std::min<int>(settings.elites, static_cast<int>(order.size()));
  if (losses[order[0]] < state.best_loss) {
    state.best_loss = losses[order[0]];
    state.best = candidates.col(order[0]);
  }

  Eigen::VectorXd mean = Eigen::VectorXd::Zero(state.mean.size()), variance = mean;
  for (int e = 0; e < elites; ++e) mean += candidates.col(order[e]) / elites;
  for (int e = 0; e < elites; ++e)
    variance += (candidates.col(order[e]) - mean).cwiseAbs2() / elites;
  const double s = settings.smoothing;
  state.mean = s * mean + (1 - s) * state.mean;
  state.deviation =
      (s * variance.cwiseSqrt() + (1 - s) * state.deviation).cwiseMax(settings.smallest_deviation);
  ++state.generation;
}

}  // namespace sanso::learn
