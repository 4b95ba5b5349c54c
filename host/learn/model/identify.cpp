// One generation: candidates to theta, N-step losses of all of them in parallel, update of the
// distribution.
#include "host/learn/model/identify.h"

#include <stdexcept>

#include "shared/files/parallel.h"

namespace sanso::learn {

namespace {

std::vector<double> on_threads(const Eigen::MatrixXd& candidates, const LossOfCandidate& loss,
                               int threads) {
  std::vector<double> losses(static_cast<std::size_t>(candidates.cols()));
  files::parallel_for(losses.size(), threads, [&](std::size_t c) {
    losses[c] = loss(candidates.col(static_cast<Eigen::Index>(c)));
  });
  return losses;
}

}  // namespace

Identification identify(const std::vector<PredictionWindow>& all_windows, const ParameterMap& map,
                        const model::Ground& ground, const model::Tangent& weights,
                        const IdentifySettings& settings, std::uint64_t seed,
                        const IdentifyRun& run) {
  if (all_windows.empty()) {
    throw std::invalid_argument(
        "identification: no window of 0.72 s without a gap in the recordings; "
        "record longer trials");
  }
  const std::vector<PredictionWindow> windows =
      thinned(all_windows, static_cast<std::size_t>(settings.max_windows));
  const auto loss_of = [&](const Eigen::VectorXd& z) {
    return n_step_loss(windows, model::make_step_model(map.parameters(z)), ground, weights);
  };
  const double loss_initial = loss_of(Eigen::VectorXd::Zero(map.size()));
  const double prior = settings.prior_weight * loss_initial / static_cast<double>(map.size());

  const LossOfCandidate penalised = [&](const Eigen::VectorXd& z) {
    return loss_of(z) + prior * z.squaredNorm();
  };
  const EvaluateCandidates evaluate = [&](const Eigen::MatrixXd& candidates) {
    return run.distribute ? run.distribute(candidates, penalised)
                          : on_threads(candidates, penalised, settings.threads);
  };
  const Eigen::VectorXd mean = run.start_z.size() == map.size()
                                   ? run.start_z
                                   : Eigen::VectorXd(Eigen::VectorXd::Zero(map.size()));
  CrossEntropyState state =
      run.continue_from ? *run.continue_from
                        : start_cross_entropy(mean, Eigen::VectorXd::Ones(map.size()), evaluate);
  while (state.generation < settings.search.generations) {
    advance_cross_entropy(state, settings.search, seed, evaluate);
    if (run.after_generation && !run.after_generation(state)) break;
  }
  const Eigen::VectorXd z = refined({windows, map, ground, weights}, prior, state.best,
                                    settings.refine, settings.threads);
  return {map.parameters(z), z, loss_initial, loss_of(z), state.generation};
}

}  // namespace sanso::learn
