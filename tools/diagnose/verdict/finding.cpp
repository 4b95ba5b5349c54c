// From what the search accepted to findings: parameters with intervals, rivals, what was promised.
#include "tools/diagnose/verdict/finding.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/explain/instants.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/verdict/yielding.h"

namespace sanso::diagnose {
namespace {

/// Deviation of a figure whose law is right but not this robot's to the last term. Groups of
/// recordings share what is wrong with a law, so they scatter less than the figure is off: the
/// stretch is measured, on cases whose answers are known.
double deviation(const DecisionSettings& decisions, const CandidateParameter& p, double value,
                 double sigma) {
  const double law = decisions.same_law * std::min(std::abs(value), std::abs(value - p.null));
  return decisions.interval_stretch * std::hypot(sigma, law);
}

std::map<std::string, VerdictParameter> parameters_of(const Comparison& comparison,
                                                      const Candidate& c,
                                                      const std::vector<double>& theta,
                                                      const Accepted& entry) {
  const double row = longest_row(comparison);
  std::map<std::string, VerdictParameter> out;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const CandidateParameter& p = c.parameters[i];
    VerdictParameter v{theta[i], theta[i], theta[i], p.unit, false};
    if (c.random && i == 0) v.at_bound = theta[i] >= p.high * (1.0 - 1e-6);
    if (c.random && i == 0)
      v.low = std::max(p.low, entry.low), v.high = std::min(p.high, entry.high);
    if (is_instant(p) && !at_null(p, theta[i])) {  // searched in steps of a row
      const double half = row + kNormal95 * entry.sigma[i];
      v.low = std::max(p.low, theta[i] - half), v.high = std::min(p.high, theta[i] + half);
    }
    if (p.role == Role::instant && entry.began)
      v.low = std::min(theta[i], entry.began->first),
      v.high = std::max(theta[i], entry.began->second);
    if (!p.structural) {
      const double sigma = deviation(comparison.settings.decisions, p, theta[i], entry.sigma[i]);
      v.low = std::max(p.low, theta[i] - kNormal95 * sigma);
      v.high = std::min(p.high, theta[i] + kNormal95 * sigma);
      v.at_bound = entry.at_bound[i] != 0 && !at_null(p, theta[i]);
      // run row by row, a filter of a larger time constant lags as much by half a row
      if (p.role == Role::filter) v.high += 0.5 * row;
    }
    out[p.name] = v;
  }
  return out;
}

/// A spring and a ripple make any smooth torque of the angle, two masses any load of one joint: the
/// terms of a series are no causes. The findings with those of their series.
std::vector<Finding> with_terms(std::vector<Finding> findings,
                                const std::vector<const Candidate*>& candidates,
                                const std::vector<TreeJoint>& tree) {
  for (std::size_t i = 0; i < findings.size(); ++i) {
    for (std::size_t k = 0; k < findings.size(); ++k) {
      if (k == i || candidates[k]->joints != candidates[i]->joints) continue;
      const unsigned common = terms_of(*candidates[i], tree) & terms_of(*candidates[k], tree);
      if (common == 0) continue;
      findings[i].terms.push_back(findings[k].effect);
      findings[i].terms_of |= common;
    }
  }
  return findings;
}

std::string strongest_regime(const std::vector<IncidenceRow>& rows) {
  const IncidenceRow* best = nullptr;
  for (const IncidenceRow& row : rows) {
    const bool in_a_regime = row.residual.signal == Signal::q && !row.residual.regime.empty();
    if (in_a_regime && (best == nullptr || row.predicted > best->predicted)) best = &row;
  }
  return best == nullptr ? "everywhere" : best->residual.regime;
}

/// Held-out energies are told as shares of the nominal model's.
double energy_to_explain(const Selection& selection) {
  return std::max(selection.nominal_heldout.sum(), 1e-9);
}

Rival rival_of(const Library& library, const Selection& selection, const Regimes& regimes,
               const Accepted& entry, const Alternative& a) {
  const Candidate& other = library[a.candidate];
  Rival rival;
  rival.effect = other.effect;
  rival.where = other.where;
  rival.heldout_gain =
      (selection.nominal_heldout.sum() - a.heldout.sum()) / energy_to_explain(selection);
  rival.behind_in_se = a.behind.certainty();
  rival.similarity = a.similarity;
  rival.said_wrong = refuted_by(incidence(*selection.around, regimes, entry.without, a.fit),
                                selection.around->settings().decisions);
  return rival;
}

/// Energy by which a rival has to be behind: what matters, and what the rival's law may be off by,
/// in `removed` by the chosen name.
double least_ahead(const Comparison& comparison, double removed) {
  return std::max(practical_energy(comparison),
                  comparison.settings.decisions.rest_of_law * removed);
}

/// These data cannot tell the rival from the chosen effect, and it is another explanation: another
/// effect that says nothing wrong and predicts as well, and not the chosen one for some of its
/// parameters. Two simulations that differ by less than `ahead` are the same prediction; but a
/// rival that needs more numbers to predict worse beyond chance is no explanation beside a simpler
/// one. Chance is that of all `rivals`.
bool as_good(const Library& library, const Selection& selection, const Candidate& chosen,
             const Alternative& a, const Rival& rival, std::size_t rivals, double ahead) {
  const DecisionSettings& decisions = selection.around->settings().decisions;
  const bool needs_more = free_parameters(library[a.candidate]) > free_parameters(chosen) &&
                          a.behind.certainty() > errors_ahead(decisions, rivals);
  const bool level = !needs_more && !a.far_behind && !beaten(decisions, a.behind, ahead, rivals);
  const bool other_place = rival.effect == chosen.effect;
  const bool same_cause =
      contains(library[a.candidate], chosen) && !find_effect(rival.effect)->another_cause;
  return level && rival.said_wrong.empty() && !same_cause && !other_place;
}

/// The finding that the i-th accepted effect is.
Finding finding_of(const Library& library, const Selection& selection, const Regimes& regimes,
                   std::size_t i) {
  const Accepted& entry = selection.accepted[i];
  const Candidate& c = library[entry.candidate];
  Finding f;
  f.effect = c.effect;
  f.chance = c.random;
  f.family = c.family;
  f.where = c.where;
  f.joints = c.joints;
  f.p_family = entry.p_family;
  const double whole = energy_to_explain(selection);
  f.heldout_gain = entry.gain.removed() / whole;
  f.heldout_gain_se = entry.gain.energy.standard_error / whole;
  f.heldout_gain_low = std::min(
      f.heldout_gain, std::max(entry.gain.energy.lower / whole,
                               entry.gain.bounded.lower / std::max(entry.gain.whole, 1e-9)));
  f.agreed_low = entry.gain.ranks.lower;
  f.parameters =
      parameters_of(*selection.around->problem, c, selection.final.model.effects[i].theta, entry);
  f.spans_null = spans_null(c, f.parameters);
  const double sure = selection.around->settings().decisions.sure_size;
  f.nearly_null = !c.random && spans_null(c, f.parameters, sure);
  f.unrepeated = unrepeated(*selection.around->problem, c, selection.final.model.effects[i].theta);
  f.incidence = incidence(*selection.around, regimes, entry.without, selection.final);
  f.regime = strongest_regime(f.incidence);
  f.one_of.push_back(c.effect);
  const auto rivals =
      static_cast<std::size_t>(std::count_if(entry.alternatives.begin(), entry.alternatives.end(),
                                             [](const Alternative& a) { return !a.far_behind; }));
  const Comparison& comparison = *selection.around->problem;
  for (const std::string_view id :
       yields_like(comparison, c, selection.final.model.effects[i].theta))
    f.one_of.emplace_back(id);
  const double ahead = least_ahead(comparison, entry.gain.removed());
  for (const Alternative& a : entry.alternatives) {
    Rival rival = rival_of(library, selection, regimes, entry, a);
    const bool listed = std::find(f.one_of.begin(), f.one_of.end(), rival.effect) != f.one_of.end();
    if (!listed && as_good(library, selection, c, a, rival, rivals, ahead))
      f.one_of.push_back(rival.effect);
    f.rivals.push_back(std::move(rival));
  }
  return f;
}

/// How far an interval lies from a value; 0: it contains it.
double distance(const VerdictParameter& p, double from) {
  return std::max({0.0, p.low - from, from - p.high});
}

}  // namespace

const char* to_string(VerdictStatus status) {
  switch (status) {
    case VerdictStatus::confirmed:
      return "CONFIRMED";
    case VerdictStatus::one_of:
      return "ONE_OF";
    case VerdictStatus::present_unnamed:
      return "PRESENT_UNNAMED";
    case VerdictStatus::absent:
      return "ABSENT";
    case VerdictStatus::refused:
      return "REFUSED";
    case VerdictStatus::unfinished:
      return "UNFINISHED";
  }
  return "REFUSED";
}

std::optional<VerdictStatus> status_from_string(std::string_view word) {
  using enum VerdictStatus;
  for (const VerdictStatus status :
       {confirmed, one_of, present_unnamed, absent, refused, unfinished})
    if (word == to_string(status)) return status;
  return std::nullopt;
}

std::string stopped_at_bounds(const Finding& finding) {
  std::string names;
  for (const auto& [name, parameter] : finding.parameters) {
    if (parameter.at_bound) names += (names.empty() ? "" : ", ") + name;
  }
  return names.empty() ? "" : names + " ends at a bound of the library";
}

std::string reserve(const Finding& finding) {
  if (finding.beside_much && finding.chance)
    return "more than noise stays beside it, and chance scatters as far as any error";
  if (finding.beside_much) return "so much stays beside it that it may be a part of something else";
  if (finding.spans_null) return "its interval contains the null";
  if (finding.unrepeated)
    return "its joint goes through too few periods to tell it from what bends over the angle";
  if (!finding.bends_with.empty())
    return "with " + finding.bends_with + " it may be one law that bends over the angle";
  if (!finding.rest_of.empty())
    return "it removes so little that it may be what the law of " + finding.rest_of + " is off by";
  if (finding.terms.empty())
    return finding.small_beside.empty() || finding.one_of.size() > 1
               ? stopped_at_bounds(finding)
               : "its size is too uncertain to be sure beside " + finding.small_beside;
  std::string text = "with";
  for (const std::string& t : finding.terms) text += " " + t;
  const char* series = finding.terms_of == kOfAngle          ? "a torque of the angle"
                       : finding.terms_of == kOfAcceleration ? "an inertia"
                       : finding.terms_of == kOfSlip         ? "a friction that builds up"
                                                             : "a load";
  return text + " it describes " + series + " that may have any cause";
}

std::vector<Finding> with_their_kind(std::vector<Finding> findings, const DecisionSettings& s) {
  for (Finding& f : findings) {
    const Effect* effect = find_effect(f.effect);
    const bool inertia = effect != nullptr && effect->terms == kOfAcceleration;
    for (const Finding& other : findings) {
      if (&other == &f || other.tolerated) continue;
      if (f.nearly_null && other.heldout_gain > f.heldout_gain) f.small_beside = other.effect;
      if (!f.chance && !f.joints.empty() && f.joints == other.joints &&
          f.heldout_gain < s.rest_of_joint * other.heldout_gain)
        f.rest_of = other.effect;
      if (other.family != f.family || other.where != f.where) continue;
      if (other.unrepeated && !f.unrepeated && !inertia) f.bends_with = other.effect;
    }
  }
  return findings;
}

VerdictStatus status_of(const Finding& finding) {
  const bool part_of_another =
      !finding.terms.empty() || !finding.bends_with.empty() || !finding.rest_of.empty();
  if (part_of_another || finding.spans_null || finding.unrepeated || finding.beside_much)
    return VerdictStatus::present_unnamed;
  if (finding.one_of.size() > 1) return VerdictStatus::one_of;
  const bool sure = stopped_at_bounds(finding).empty() && finding.small_beside.empty();
  return sure ? VerdictStatus::confirmed : VerdictStatus::present_unnamed;
}

VerdictStatus overall_status(const std::vector<Finding>& findings, bool something_unnamed) {
  const auto some = [&](VerdictStatus s) {
    return std::any_of(findings.begin(), findings.end(),
                       [s](const Finding& f) { return f.status == s; });
  };
  if (something_unnamed || some(VerdictStatus::present_unnamed))
    return VerdictStatus::present_unnamed;
  if (findings.empty()) return VerdictStatus::absent;
  return some(VerdictStatus::one_of) ? VerdictStatus::one_of : VerdictStatus::confirmed;
}

unsigned terms_of(const Candidate& c, const std::vector<TreeJoint>& tree) {
  const Effect* effect = find_effect(c.effect);
  if (effect == nullptr || c.joints.empty()) return 0;
  const bool on_base = std::all_of(c.joints.begin(), c.joints.end(),
                                   [&](std::size_t j) { return tree[j].parent < 0; });
  return effect->scope == Scope::link && !on_base ? 0 : effect->terms;
}

bool spans_null(const Candidate& c, const std::map<std::string, VerdictParameter>& parameters,
                double stretch) {
  bool asked = false;
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    const CandidateParameter& p = c.parameters[i];
    // where something begins is not how much of it there is
    if (c.random ? i > 0 : p.structural || p.role == Role::position) continue;
    const VerdictParameter& v = parameters.at(p.name);
    const double low = v.value - stretch * (v.value - v.low);
    const double high = v.value + stretch * (v.high - v.value);
    if (low > p.null || high < p.null || v.at_bound) return false;
    asked = true;
  }
  return asked;
}

bool is_tolerated(const Finding& finding, const Candidate& candidate, const SimParams& nominal,
                  const ToleranceSettings& tolerances) {
  const Law& law = find_effect(candidate.effect)->law;
  if (law.within == nullptr) return false;
  const auto is_of = [](const std::vector<std::size_t>& some, std::size_t k) {
    return std::find(some.begin(), some.end(), k) != some.end();
  };
  double beyond = 0.0;
  for (std::size_t k = 0; k < candidate.parameters.size(); ++k) {
    const CandidateParameter& p = candidate.parameters[k];
    if (p.structural || is_of(law.shape, k)) continue;
    const VerdictParameter& v = finding.parameters.at(p.name);
    if (v.at_bound) return false;  // its interval has one side
    const double off = distance(v, p.null);
    if (!is_of(law.parameters, k) && off > 0.0) return false;
    beyond = std::hypot(beyond, off);
  }
  const auto small = [&](std::size_t j) {
    // null: the figure is in the tolerance's unit
    const double unit = law.unit == nullptr ? 1.0 : law.unit(nominal, j);
    return unit > 0.0 && beyond * unit <= tolerances.*law.within;
  };
  if (!candidate.joints.empty())
    return std::all_of(candidate.joints.begin(), candidate.joints.end(), small);
  for (std::size_t j = 0; j < nominal.size(); ++j) {  // of the whole robot: at every joint
    if (!small(j)) return false;
  }
  return true;
}

std::vector<Finding> accepted_so_far(const Library& library, const Selection& selection) {
  std::vector<Finding> out;
  const std::vector<double> sigma = parameter_sigmas(selection.final, library);
  std::size_t next = 0;
  for (std::size_t i = 0; i < selection.accepted.size(); ++i) {
    Accepted entry;
    const Candidate& c = library[selection.accepted[i].candidate];
    for (std::size_t k = 0; k < c.parameters.size(); ++k, ++next) {
      const bool fitted = next < sigma.size() && !c.parameters[k].structural;
      entry.sigma.push_back(fitted ? sigma[next] : 0.0);
      entry.at_bound.push_back(next < selection.final.fixed.size() ? selection.final.fixed[next]
                                                                   : char{0});
    }
    Finding f;
    f.effect = c.effect, f.family = c.family, f.where = c.where, f.joints = c.joints;
    f.regime = "everywhere";
    f.status = VerdictStatus::unfinished;
    f.p_family = selection.accepted[i].p_family;
    f.one_of = {c.effect};
    f.parameters =
        parameters_of(*selection.around->problem, c, selection.final.model.effects[i].theta, entry);
    out.push_back(std::move(f));
  }
  return out;
}

std::vector<Finding> findings_of(const Library& library, const Selection& selection,
                                 const Regimes& regimes) {
  std::vector<Finding> out;
  std::vector<const Candidate*> candidates;  // by finding
  const SimParams& nominal = selection.around->problem->sources.front().nominal;
  const ToleranceSettings& tolerances = selection.around->settings().tolerances;
  for (std::size_t i = 0; i < selection.accepted.size(); ++i) {
    if (!selection.accepted[i].contradicted.empty()) continue;
    candidates.push_back(&library[selection.accepted[i].candidate]);
    out.push_back(finding_of(library, selection, regimes, i));
    out.back().tolerated = is_tolerated(out.back(), *candidates.back(), nominal, tolerances);
  }
  out = with_terms(std::move(out), candidates, nominal.tree.joints);
  out = with_their_kind(std::move(out), selection.around->settings().decisions);
  for (Finding& f : out) f.status = status_of(f);
  return out;
}

}  // namespace sanso::diagnose
