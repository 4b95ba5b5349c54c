// Identification of the analytical model: parameters near the initial ones that predict the
// recordings best over N steps. Cross-entropy method on the N-step loss in W_x (paper, eq. 6), then
// Gauss-Newton (refine.h); every candidate is physically consistent. From positions and velocities
// alone the common scale of all masses, stiffnesses and damping is not determined; the prior keeps
// it near the initial model.
#pragma once

#include <functional>
#include <optional>

#include "host/learn/model/cross_entropy.h"
#include "host/learn/model/parameter_map.h"
#include "host/learn/model/prediction.h"
#include "host/learn/model/refine.h"

namespace sanso::learn {

struct IdentifySettings {
  CrossEntropySettings search;
  RefineSettings refine;
  double prior_weight = 0.02;
  int max_windows = 240;
  int threads = 2;

  constexpr void visit(auto&& field) {
    search.visit(field);
    refine.visit(field);
    field("prior_weight", prior_weight, "1", 0.0, 10.0,
          "of |z|^2 / size, relative to the initial model's loss: ties go to the initial model");
    field("max_windows", max_windows, "windows", 8, 1000000,
          "recordings are thinned to so many, evenly: more change the answer less than the seed");
    field("threads", threads, "threads", 1, 256, "of the search");
  }
};

struct Identification {
  model::ModelParameters parameters;
  Eigen::VectorXd z;        // in prior deviations, order of ParameterMap::names()
  double loss_initial = 0;  // N-step loss of the initial model on the windows used
  double loss = 0;          // and of `parameters`
  int generations = 0;
};

/// Losses of candidates (columns), in their order, by calling `loss` for each: on threads of this
/// process, or spread over many.
using LossOfCandidate = std::function<double(const Eigen::VectorXd&)>;
using DistributeCandidates = std::function<std::vector<double>(const Eigen::MatrixXd& candidates,
                                                               const LossOfCandidate& loss)>;

/// Where a search begins and who takes part in it; by default from the initial model, on threads of
/// this process.
struct IdentifyRun {
  Eigen::VectorXd start_z;  // (n) empty: the initial model
  // of the same search, stopped; goes on with the same numbers
  std::optional<CrossEntropyState> continue_from;
  /// Sees the state (progress, storing); returning false stops the search there.
  std::function<bool(const CrossEntropyState&)> after_generation;
  DistributeCandidates distribute;
};

/// Throws std::invalid_argument when there are no windows.
Identification identify(const std::vector<PredictionWindow>& windows, const ParameterMap& map,
                        const model::Ground& ground, const model::Tangent& weights,
                        const IdentifySettings& settings, std::uint64_t seed,
                        const IdentifyRun& run = {});

}  // namespace sanso::learn
