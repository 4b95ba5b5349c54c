// Events over all of the recorded time, for the search to look at and for the verdict to tell.
#include "tools/diagnose/explain/whole_time.h"

#include <algorithm>
#include <limits>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/compare/start_elimination.h"
#include "tools/diagnose/explain/rivals.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

ProblemOptions everything(ProblemOptions options, const Settings& settings) {
  options.maximum_rows = 4 * settings.data.maximum_rows;
  options.maximum_shots = std::numeric_limits<int>::max();
  options.secondary = false;
  return options;
}

/// What the nominal model's tolerances scatter: where a joint nearly sticks, a model that is right
/// parts from the robot too. Draws of all nuisances z change the error by
///
///   r(z) - r - A z      A z a fit would have taken up
///
/// and so do commands that wait until servos look. What counts is the largest mean square, by
/// channel and shot.
Eigen::MatrixXd tolerated(const Surroundings& around, const Model& model,
                          const Eigen::VectorXd& r) {
  const Library& library = *around.library;
  const Problem& problem = around.problem;
  constexpr std::uint64_t kSeed = 11;
  const auto draws = static_cast<std::size_t>(problem->settings.decisions.tolerance_draws);
  std::vector<Eigen::MatrixXd> drawn(draws);
  parallel_for(draws, [&](std::size_t b) {
    Random random(kSeed, b);
    Model moved = model;
    moved.nuisance.resize(library.nuisances.size(), 0.0);
    Eigen::VectorXd z(around.A.cols());
    for (std::size_t k = 0; k < moved.nuisance.size(); ++k) {
      z[k] = 2.0 * random.uniform() - 1.0;
      moved.nuisance[k] += library.nuisances[k].tolerance * z[k];
    }
    const std::uint64_t waits = random.bits() | 1U;
    drawn[b] = mean_squares(
        problem, around.starts.project(polled_prediction_error(problem, library, moved, waits) - r -
                                       around.A * z));
  });
  Eigen::MatrixXd out = drawn.front();
  for (const Eigen::MatrixXd& one : drawn) out = out.cwiseMax(one);
  return out;
}

}  // namespace

WholeTime::WholeTime(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                     const ProblemOptions& search, const Settings& settings)
    : problem_(make_problem(sources, noise, everything(search, settings), settings)) {
  Library calibrated;
  calibrated.nuisances = make_nuisances(*problem_);
  nominal_ = left_by(calibrated, Model{});
}

bool WholeTime::nominal_matters() const {
  return repeated(nominal_.events).energy >= practical_energy(*problem_);
}

ProblemOptions WholeTime::with_instants(ProblemOptions search) const {
  // three shots a recording and instant, as many in all as half the search's
  const std::size_t allowed = static_cast<std::size_t>(problem_->settings.data.maximum_shots) /
                              (2 * 3 * problem_->sources.size());
  search.instants = instants_of(*problem_, nominal_.events, std::max<std::size_t>(1, allowed));
  for (const Event& e : nominal_.events) search.struck.push_back(e.joint);
  return search;
}

EventsLeft WholeTime::left_by(const Library& library, const Model& model) const {
  const Problem corrected = step_corrected(problem_, library, model);
  const StartElimination starts(corrected, library, model);
  const Eigen::VectorXd r = prediction_error(corrected, library, model);
  const Eigen::VectorXd error = starts.project(r);
  EventsLeft out{find_events(corrected, error), error.squaredNorm()};
  if (!out.events.empty())
    out.events = find_events(corrected, error,
                             tolerated(make_surroundings(corrected, library, model), model, r));
  return out;
}

}  // namespace sanso::diagnose
