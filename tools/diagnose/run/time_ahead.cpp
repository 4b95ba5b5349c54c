// One pass is timed; how many there are follows from candidates, rivals and groups.
#include "tools/diagnose/run/time_ahead.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "tools/diagnose/compare/prediction_error.h"

namespace sanso::diagnose {
namespace {

/// Gauss-Newton steps of a fit that stops by itself, parameters of an effect: usual figures.
constexpr double kSteps = 4.0, kColumns = 2.0;

}  // namespace

Passes passes_of(const Comparison& comparison, const Library& library) {
  double probes = 0.0;
  for (const Candidate& c : library.candidates) probes += static_cast<double>(c.probes.size());
  const double around = 2.0 * static_cast<double>(comparison.joints.size()) +
                        static_cast<double>(library.nuisances.size());
  const double fit = kSteps * (1.0 + kColumns) + static_cast<double>(comparison.groups);
  Passes out;
  out.look = probes + around;
  out.name = probes + 2.0 * around + comparison.settings.decisions.rivals * fit;
  return out;
}

std::string time_ahead(const Problem& problem, const Library& library) {
  const auto begin = std::chrono::steady_clock::now();
  prediction_error(problem, library, Model{});
  const double pass =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const Passes passes = passes_of(*problem, library);
  return fmt::format("about {:.2g} s to look, about {:.2g} s for every name, {} names at most",
                     passes.look * pass, passes.name * pass,
                     problem->settings.decisions.maximum_effects);
}

}  // namespace sanso::diagnose
