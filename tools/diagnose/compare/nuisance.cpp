// Nuisances from the tolerances that stand with the effects, and models applied to parameters.
#include <algorithm>
#include <cassert>
#include <cmath>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {
namespace {

Nuisance make(const Tolerated& quantity, const std::string& name, double tolerance,
              std::vector<std::size_t> joints, std::vector<double> direction) {
  const Effect& effect = *quantity.effect;
  assert(effect.parameters.size() == direction.size());
  Nuisance n;
  n.name = name;
  n.effect = std::string(effect.id);
  n.tolerance = tolerance;
  n.joints = std::move(joints);
  n.null = effect.null();
  n.direction = std::move(direction);
  n.run = effect.apply;
  return n;
}

}  // namespace

std::vector<double> Nuisance::theta(double value) const {
  std::vector<double> out = null;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] += value * direction[i];
  return out;
}

void Nuisance::apply(SimParams& params, double value) const {
  // beyond these no body or gain remains; a fit that gets there has left every tolerance
  const double bounded = std::max(-0.9, value);
  const std::vector<double> values = theta(bounded);
  for (const std::size_t j : joints) run(params, j, values);
}

std::vector<Nuisance> make_nuisances(const Comparison& comparison) {
  std::vector<Nuisance> out;
  const SimParams& nominal = comparison.sources.front().nominal;
  const ToleranceSettings& tolerances = comparison.settings.tolerances;
  const std::vector<Tolerated> quantities = tolerated_quantities();
  std::vector<std::size_t> all;
  for (std::size_t j = 0; j < comparison.joints.size(); ++j) {
    all.push_back(j);
    for (const Tolerated& quantity : quantities) {
      const Tolerance& t = *quantity.tolerance;
      if (t.common) continue;
      std::vector<double> direction = t.direction(nominal, j);
      if (direction.empty()) continue;
      const double deviation = nominal.tree.joints[j].prismatic
                                   ? t.sliding * tolerances.*t.deviation
                                   : tolerances.*t.deviation;
      out.push_back(make(quantity, std::string(t.name) + " of " + comparison.joints[j], deviation,
                         {j}, std::move(direction)));
    }
  }
  for (const Tolerated& quantity : quantities) {
    const Tolerance& t = *quantity.tolerance;
    if (t.common)
      out.push_back(make(quantity, std::string(t.name), tolerances.*t.deviation, all,
                         t.direction(nominal, 0)));
  }
  return out;
}

bool at_null(const CandidateParameter& p, double value) {
  return std::abs(value - p.null) <= 1e-6 * std::max(p.typical, p.high - p.low);
}

bool Model::has(std::size_t candidate) const {
  return std::any_of(effects.begin(), effects.end(),
                     [&](const Chosen& c) { return c.candidate == candidate; });
}

void Library::apply(const Model& model, SimParams& params) const {
  for (std::size_t i = 0; i < model.nuisance.size(); ++i) {
    if (model.nuisance[i] != 0.0) nuisances[i].apply(params, model.nuisance[i]);
  }
  for (const Chosen& c : model.effects) candidates[c.candidate].apply(params, c.theta);
}

std::string Candidate::title() const {
  std::string text = effect;
  for (std::size_t i = 0; i < where.size(); ++i) text += (i == 0 ? " at " : ", ") + where[i];
  return text;
}

}  // namespace sanso::diagnose
