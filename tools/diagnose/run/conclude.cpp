#include "tools/diagnose/run/conclude.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tools/diagnose/constants.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/locate/incidence.h"

namespace sanso::diagnose {
namespace {

const Candidate& candidate(const Library& library, int i) { return library.candidates[static_cast<std::size_t>(i)]; }

std::map<std::string, VerdictParameter> parameters_of(const Candidate& c, const std::vector<double>& theta,
                                                      const Accepted& entry) {
  std::map<std::string, VerdictParameter> out;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const CandidateParameter& p = c.parameters[i];
    VerdictParameter v{theta[i], theta[i], theta[i], p.unit, false};
    if (c.random && i == 0) v.at_bound = theta[i] >= p.high * (1.0 - 1e-6);
    if (c.random && i == 0) v.low = std::max(p.low, entry.low), v.high = std::min(p.high, entry.high);
    if (!p.structural) {
      v.low = std::max(p.low, theta[i] - 1.96 * entry.sigma[i]);
      v.high = std::min(p.high, theta[i] + 1.96 * entry.sigma[i]);
      v.at_bound = entry.at_bound[i] != 0 && !at_null(p, theta[i]);
    }
    out[p.name] = v;
  }
  return out;
}

/// A rival that is the chosen effect for some of its parameters is no other explanation.
bool contains(const Candidate& larger, const Candidate& chosen) {
  return larger.where == chosen.where &&
         std::find(larger.contains.begin(), larger.contains.end(), chosen.effect) != larger.contains.end();
}

/// A spring and a ripple make any smooth torque of the angle, two masses any load of one joint: the terms of a series
/// are no causes.
void mark_terms(std::vector<Finding>& findings, const std::vector<const Candidate*>& candidates,
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
}

std::string strongest_regime(const std::vector<IncidenceRow>& rows) {
  const IncidenceRow* best = nullptr;
  for (const IncidenceRow& row : rows) {
    if (row.residual.rfind("position, ", 0) == 0 && (best == nullptr || row.predicted > best->predicted)) best = &row;
  }
  return best == nullptr ? "everywhere" : best->residual.substr(10);
}

}  // namespace

unsigned terms_of(const Candidate& c, const std::vector<TreeJoint>& tree) {
  const Effect* effect = find_effect(c.effect);
  if (effect == nullptr || c.joints.empty()) return 0;
  const bool on_base = std::all_of(c.joints.begin(), c.joints.end(),
                                   [&](int j) { return tree[static_cast<std::size_t>(j)].parent < 0; });
  return effect->scope == Scope::link && !on_base ? 0 : effect->terms;
}

bool spans_null(const Candidate& c, const std::map<std::string, VerdictParameter>& parameters) {
  bool asked = false;
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    const CandidateParameter& p = c.parameters[i];
    if (c.random ? i > 0 : p.structural) continue;
    const VerdictParameter& v = parameters.at(p.name);
    if (v.low > p.null || v.high < p.null || v.at_bound) return false;
    asked = true;
  }
  return asked;
}

std::vector<Finding> findings_of(const Library& library, const Selection& selection, const Regimes& regimes) {
  std::vector<Finding> out;
  std::vector<const Candidate*> candidates;  // by finding
  const double excess = std::max(selection.nominal_heldout.sum(), 1e-9);
  for (std::size_t i = 0; i < selection.accepted.size(); ++i) {
    const Accepted& entry = selection.accepted[i];
    if (!entry.contradicted.empty()) continue;
    const Candidate& c = candidate(library, entry.candidate);
    Finding f;
    candidates.push_back(&c);
    f.effect = c.effect;
    f.family = c.family;
    f.where = c.where;
    f.p_family = entry.p_family;
    f.heldout_gain = entry.gain.total / excess;
    f.heldout_gain_se = entry.gain.standard_error / excess;
    f.heldout_gain_low = entry.gain.lower / excess;
    f.parameters = parameters_of(c, selection.final.model.effects[i].theta, entry);
    f.spans_null = spans_null(c, f.parameters);
    f.incidence = incidence(*selection.around, regimes, entry.without, selection.final);
    f.regime = strongest_regime(f.incidence);
    f.one_of.push_back(c.effect);
    for (const Alternative& a : entry.alternatives) {
      const Candidate& other = candidate(library, a.candidate);
      Rival rival;
      rival.effect = other.effect;
      rival.where = other.where;
      rival.heldout_gain = (selection.nominal_heldout.sum() - a.heldout.sum()) / excess;
      rival.behind_in_se = a.behind / std::max(a.behind_se, 1e-9);
      rival.similarity = a.similarity;
      rival.said_wrong = refuted_by(incidence(*selection.around, regimes, entry.without, a.fit));
      // two simulations that differ by less than what matters are the same prediction
      const bool level = a.behind < std::max(constants::kStandardErrors * a.behind_se + kNoiseUnit,
                                             practical_energy(*selection.around->problem));
      const bool other_place = other.effect == c.effect;
      if (level && rival.said_wrong.empty() && !contains(other, c) && !other_place &&
          std::find(f.one_of.begin(), f.one_of.end(), other.effect) == f.one_of.end()) {
        f.one_of.push_back(other.effect);
      }
      f.rivals.push_back(std::move(rival));
    }
    out.push_back(std::move(f));
  }
  mark_terms(out, candidates, selection.around->problem->sources.front().nominal.tree.joints);
  for (Finding& f : out) f.status = status_of(f);
  return out;
}

double remaining_share(const Problem& problem, const Selection& selection) {
  const Eigen::VectorXd before = selection.around->starts.project(selection.nominal.r);
  const Eigen::VectorXd after = selection.around->starts.project(selection.final.r);
  double excess_before = 0.0, excess_after = 0.0;
  for (std::size_t c = 0; c < problem.channels.size(); ++c) {
    const Observed& channel = problem.channels[c];
    if (channel.signal != Signal::q) continue;
    for (const Shot& shot : problem.shots) {
      const auto from = static_cast<Eigen::Index>(shot.offset + c * shot.rows);
      const auto rows = static_cast<Eigen::Index>(shot.rows);
      // in units of the measurement noise (or the trust floor), whatever the channel was scaled by
      const double unit = channel.sigma * channel.sigma / (channel.floor * channel.floor);
      excess_before += unit * before.segment(from, rows).squaredNorm() - static_cast<double>(rows);
      excess_after += unit * after.segment(from, rows).squaredNorm() - static_cast<double>(rows);
      if (selection.expected_scatter.size() > 0)  // what chance explains is not left
        excess_after -= unit * selection.expected_scatter.segment(from, rows).sum();
    }
  }
  return excess_before > 0.0 ? std::clamp(excess_after / excess_before, 0.0, 1.0) : 0.0;
}

namespace {

/// Some candidate stood out in the first screening: the error is no noise, whether or not a name passed the later
/// gates.
bool detected(const Selection& selection) {
  return std::any_of(selection.first.probes.begin(), selection.first.probes.end(),
                     [](const ProbeScore& p) { return p.p_family < constants::kFamilyWise; });
}

/// The joint whose remaining missing torque is most surely physics: predictable, and larger than noise makes it.
const Predictability* most_predictable(const std::vector<Predictability>& left) {
  const Predictability* best = nullptr;
  const double level = constants::kFamilyWise / static_cast<double>(std::max<std::size_t>(1, left.size()));
  for (const Predictability& p : left) {
    // p resolves to 1 / (kBootstrap + 1); with many joints the smallest p is all one can ask for
    const bool significant = p.p <= std::max(level, 1.0 / (constants::kBootstrap + 1.0) + 1e-12);
    if (!significant || p.explained < 0.1 || p.torque_rms < 1.5 * p.noise_rms) continue;
    if (best == nullptr || p.explained > best->explained) best = &p;
  }
  return best;
}

std::string places(const std::vector<std::string>& where) {
  if (where.empty()) return "the whole robot";
  std::string text = where.front();
  for (std::size_t i = 1; i < where.size(); ++i) text += ", " + where[i];
  return text;
}

std::string sentence(const Finding& f) {
  std::string text = f.effect;
  if (f.status == VerdictStatus::one_of) {
    text = "one of {";
    for (std::size_t i = 0; i < f.one_of.size(); ++i) text += (i == 0 ? "" : ", ") + f.one_of[i];
    text += "}";
  }
  text += " at " + places(f.where);
  if (!f.parameters.empty() && f.status == VerdictStatus::confirmed) {
    const auto& [name, value] = *f.parameters.begin();
    text += fmt::format(" ({} {:.3g} {})", name, value.value, value.unit);
  }
  if (const std::string why = reserve(f); !why.empty()) text += " (not confirmed: " + why + ")";
  return text;
}

/// Effects that stay in the model as a description though a residual speaks against them; empty: none.
std::string stand_ins(const Library& library, const Selection& selection) {
  std::string text;
  for (const Accepted& entry : selection.accepted) {
    if (entry.contradicted.empty()) continue;
    text += (text.empty() ? "" : "; ") + candidate(library, entry.candidate).title() + " (" + entry.contradicted + ")";
  }
  return text;
}

}  // namespace

void decide(Verdict& verdict, const Problem& problem, const Library& library, const Selection& selection,
            const std::vector<Predictability>& left, const std::string& location) {
  const double share = remaining_share(problem, selection);
  const Predictability* unnamed = most_predictable(left);
  verdict.notes.push_back(
      fmt::format("left: {:.1f} % of the position error beyond noise, {:.2f} noise levels, predictable {:.0f} %",
                  100 * share, position_error_level(*selection.around, selection.final.r, selection.expected_scatter),
                  unnamed != nullptr ? 100 * unnamed->explained : 0.0));
  // however loud the effects that have a name were: what is left besides is no noise
  const bool inadequate =
      position_error_level(*selection.around, selection.final.r, selection.expected_scatter) > constants::kAdequate &&
      detected(selection);
  if (unnamed != nullptr) {
    Unexplained u;
    u.predictable = unnamed->explained;
    u.p = unnamed->p;
    u.energy_share = share;
    u.where = problem.joints[static_cast<std::size_t>(unnamed->joint)];
    u.regime = location;
    verdict.unexplained = u;
  }
  const std::string described = stand_ins(library, selection);
  const bool stopped = std::any_of(verdict.findings.begin(), verdict.findings.end(),
                                   [](const Finding& f) { return f.status == VerdictStatus::present_unnamed; });
  if (unnamed == nullptr && (inadequate || !described.empty() || stopped)) {
    Unexplained u;
    u.energy_share = share;
    u.where = verdict.locations.empty() ? problem.joints.front() : verdict.locations.front().where;
    u.regime = location;
    verdict.unexplained = u;
  }
  if (!described.empty() || stopped || unnamed != nullptr || inadequate) {
    verdict.status = VerdictStatus::present_unnamed;
  } else if (verdict.findings.empty()) {
    verdict.status = VerdictStatus::absent;
  } else {
    const bool several = std::any_of(verdict.findings.begin(), verdict.findings.end(),
                                     [](const Finding& f) { return f.status == VerdictStatus::one_of; });
    verdict.status = several ? VerdictStatus::one_of : VerdictStatus::confirmed;
  }
  verdict.mismatch = verdict.status != VerdictStatus::absent;
  if (verdict.status == VerdictStatus::absent) {
    verdict.answer = "No mismatch found beyond noise and the nominal model's tolerances.";
    return;
  }
  if (verdict.findings.empty()) {
    verdict.answer = "Physics is missing, but no name of the library passes every gate: " + verdict.unexplained->where +
                     " (" + location + ").";
    if (!described.empty()) verdict.answer += " Described, not explained, by " + described + ".";
    return;
  }
  verdict.answer = "Missing: ";
  for (std::size_t i = 0; i < verdict.findings.size(); ++i)
    verdict.answer += (i == 0 ? "" : "; ") + sentence(verdict.findings[i]);
  verdict.answer += verdict.status == VerdictStatus::present_unnamed
                        ? fmt::format("; {:.0f} % of the error beyond noise stays without a name.", 100 * share)
                        : ".";
  if (!described.empty()) verdict.answer += " Described, not explained, by " + described + ".";
}

void add_limits(Verdict& verdict, const Library& library, const Selection& selection) {
  const Screening& screening = selection.first;
  std::map<std::string, double> best_signature;  // effect -> noise levels that its largest probe makes
  for (const ProbeScore& probe : screening.probes) {
    const Candidate& c = candidate(library, probe.candidate);
    double& best = best_signature[c.effect];
    best = std::max(best, probe.signature);
    if (probe.probe != 0 || c.parameters.empty() || c.parameters[0].structural) continue;
    const double size = std::abs(c.probes[0][0] - c.parameters[0].null);
    if (!(probe.signature > 1e-6) || size <= 0.0) continue;
    // 80 % power at the family-wise level: critical value + 0.84 standard deviations
    const double smallest = size * (screening.critical + 0.84) / probe.signature;
    if (smallest > c.parameters[0].high - c.parameters[0].low) continue;
    std::string where;
    for (const std::string& w : c.where) where += (where.empty() ? "" : ", ") + w;
    verdict.detectable.push_back(
        {c.effect, where.empty() ? "robot" : where, c.parameters[0].name, c.parameters[0].unit, smallest});
  }
  for (const auto& [effect, signature] : best_signature) {
    if (signature >= constants::kTestable) continue;
    verdict.untestable.push_back(
        {effect, fmt::format("a typical size changes these recordings by {:.2g} noise levels only (needs {})",
                             signature, constants::kTestable)});
  }
}

}  // namespace sanso::diagnose
