// What these data could not show, from the signatures of the first screening.
#include "tools/diagnose/verdict/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace sanso::diagnose {
namespace {

std::string places(const Candidate& c) {
  std::string where;
  for (const std::string& w : c.where) where += (where.empty() ? "" : ", ") + w;
  return where.empty() ? "robot" : where;
}

}  // namespace

std::vector<Untestable> too_quiet(const Library& library, const Screening& screening,
                                  const DecisionSettings& decisions) {
  // effect -> noise levels that its largest probe makes
  std::map<std::string, double> best_signature;
  for (const ProbeScore& probe : screening.probes) {
    double& best = best_signature[library[probe.candidate].effect];
    best = std::max(best, probe.signature);
  }
  std::vector<Untestable> out;
  for (const auto& [effect, signature] : best_signature) {
    if (signature >= decisions.testable) continue;
    out.push_back(
        {effect,
         fmt::format(
             "a typical size changes these recordings by {:.2g} noise levels only (needs {})",
             signature, decisions.testable)});
  }
  return out;
}

std::vector<Detectable> smallest_sizes(const Library& library, const Screening& screening) {
  std::vector<Detectable> out;
  for (const ProbeScore& probe : screening.probes) {
    const Candidate& c = library[probe.candidate];
    if (probe.probe != 0 || c.parameters.empty() || c.parameters[0].structural) continue;
    const CandidateParameter& p = c.parameters[0];
    const double size = std::abs(c.probes[0][0] - p.null);
    if (!(probe.signature > 1e-6) || size <= 0.0) continue;
    // 80 % power at the family-wise level: critical value + 0.84 standard deviations
    const double smallest = size * (screening.critical + 0.84) / probe.signature;
    if (smallest > p.high - p.low) continue;
    out.push_back({c.effect, places(c), p.name, p.unit, smallest});
  }
  return out;
}

}  // namespace sanso::diagnose
