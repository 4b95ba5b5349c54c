// Neighbouring windows share most of their ticks, so that blocks of them are drawn.
#include "host/learn/model/ensemble.h"

#include <algorithm>
#include <random>

namespace sanso::learn {
namespace {

constexpr std::size_t kBlock = 6;  // windows

/// As many windows as there are, in blocks of neighbours drawn with replacement.
std::vector<PredictionWindow> drawn_anew(const std::vector<PredictionWindow>& windows,
                                         std::mt19937_64& random) {
  std::vector<PredictionWindow> out;
  out.reserve(windows.size());
  while (out.size() < windows.size()) {
    const std::size_t first = random() % windows.size();
    const std::size_t count = std::min(kBlock, windows.size() - out.size());
    for (std::size_t i = 0; i < count; ++i) out.push_back(windows[(first + i) % windows.size()]);
  }
  return out;
}

}  // namespace

std::vector<Eigen::VectorXd> ensemble(const RefineProblem& problem, double prior,
                                      const Eigen::VectorXd& z, const EnsembleSettings& settings,
                                      std::uint64_t seed, int threads) {
  std::vector<Eigen::VectorXd> out;
  if (problem.windows.empty()) return out;
  RefineSettings refine;
  refine.steps = settings.steps;
  refine.enough = 0.0;
  std::mt19937_64 random(seed);
  for (int e = 0; e < settings.members; ++e) {
    const std::vector<PredictionWindow> windows = drawn_anew(problem.windows, random);
    out.push_back(refined({windows, problem.map, problem.ground, problem.weights}, prior, z, refine,
                          threads));
  }
  return out;
}

}  // namespace sanso::learn
