// The cross-entropy method: minimises a function by sampling a Gaussian, keeping the best, and
// fitting the Gaussian to them. [Kochenderfer and Wheeler 2019, "Algorithms for Optimization",
// section 8.4] Every generation's samples depend only on the seed, its number and the distribution:
// a search that stops after any generation continues from its state with the same numbers, and it
// does not matter who evaluates the candidates.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

namespace sanso::learn {

struct CrossEntropySettings {
  int population = 64;
  int elites = 12;
  int generations = 15;
  double smoothing = 0.7;
  double smallest_deviation = 0.02;

  constexpr void visit(auto&& field) {
    field("population", population, "candidates", 4, 100000,
          "of a generation: twice the parameters");
    field("elites", elites, "candidates", 2, 100000, "a fifth of them make the next distribution");
    field("generations", generations, "generations", 1, 10000,
          "of a round; the next round goes on where this one ends");
    field("smoothing", smoothing, "share", 0.01, 1.0,
          "of the elites' statistics in the new distribution");
    field("smallest_deviation", smallest_deviation, "prior deviations", 0.0, 1.0,
          "keeps the search alive");
  }
};

/// Where a search stands; enough to continue it.
struct CrossEntropyState {
  int generation = 0;               // generations done
  Eigen::VectorXd mean, deviation;  // (n) of the sampling Gaussian
  Eigen::VectorXd best;             // (n) best candidate ever seen, the starting mean included
  double best_loss = 0;
};

/// Losses of all candidates (columns of an n x population matrix), in their order. Not finite
/// counts as worst.
using EvaluateCandidates = std::function<std::vector<double>(const Eigen::MatrixXd& candidates)>;

/// Starts at `mean` with `deviation`; evaluates the mean once.
CrossEntropyState start_cross_entropy(const Eigen::VectorXd& mean, const Eigen::VectorXd& deviation,
                                      const EvaluateCandidates& evaluate);
/// One generation.
void advance_cross_entropy(CrossEntropyState& state, const CrossEntropySettings& settings,
                           std::uint64_t seed, const EvaluateCandidates& evaluate);

}  // namespace sanso::learn
