// What a search by samples leaves: Gauss-Newton on the same N-step loss. The loss is a sum of
// squares, and its slopes by differences cost one roll-out a parameter, however many there are.
#pragma once

#include "host/learn/model/parameter_map.h"
#include "host/learn/model/prediction.h"

namespace sanso::learn {

struct RefineSettings {
  int steps = 8;
  double enough = 1e-3;

  constexpr void visit(auto&& field) {
    field("refine_steps", steps, "steps", 0, 1000,
          "of Gauss-Newton after the search; nearly all is found in five. 0: the search alone "
          "(paper)");
    field("refine_enough", enough, "share", 0.0, 1.0,
          "of the loss: a step that gains less is the last");
  }
};

/// What a refinement is of.
struct RefineProblem {
  const std::vector<PredictionWindow>& windows;
  const ParameterMap& map;
  const model::Ground& ground;
  const model::Tangent& weights;
};

/// `z` moved to smaller N-step loss plus prior |z|^2 (Levenberg's damping, so never to a larger
/// one). Where a prediction from `z` is not finite: `z`. `threads`: any number gives the same bits.
Eigen::VectorXd refined(const RefineProblem& problem, double prior, Eigen::VectorXd z,
                        const RefineSettings& settings, int threads);

}  // namespace sanso::learn
