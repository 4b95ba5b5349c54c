// Events over all of the recorded time, for the search to look at and for the verdict to tell.
#include "tools/diagnose/explain/whole_time.h"

#include <algorithm>
#include <limits>

#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/explain/rivals.h"

namespace sanso::diagnose {
namespace {

ProblemOptions everything(ProblemOptions options, const Settings& settings) {
  options.maximum_rows = 4 * settings.data.maximum_rows;
  options.maximum_shots = std::numeric_limits<int>::max();
  options.secondary = false;
  return options;
}

}  // namespace

WholeTime::WholeTime(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                     const ProblemOptions& search, const Settings& settings)
    : problem_(make_problem(sources, noise, everything(search, settings), settings)) {
  Library calibrated;
  calibrated.nuisances = make_nuisances(problem_);
  nominal_ = left_by(calibrated, Model{});
}

bool WholeTime::nominal_matters() const {
  return repeated(nominal_.events).energy >= practical_energy(problem_);
}

ProblemOptions WholeTime::with_instants(ProblemOptions search) const {
  // three shots a recording and instant, as many in all as half the search's
  const std::size_t allowed = static_cast<std::size_t>(problem_.settings.data.maximum_shots) /
                              (2 * 3 * problem_.sources.size());
  search.instants = instants_of(problem_, nominal_.events, std::max<std::size_t>(1, allowed));
  for (const Event& e : nominal_.events) search.struck.push_back(e.joint);
  return search;
}

EventsLeft WholeTime::left_by(const Library& library, const Model& model) {
  correct_step(problem_, library, model);
  const StartElimination starts(problem_, library, model);
  const Eigen::VectorXd error = starts.project(prediction_error(problem_, library, model));
  return {find_events(problem_, error), error.squaredNorm()};
}

}  // namespace sanso::diagnose
