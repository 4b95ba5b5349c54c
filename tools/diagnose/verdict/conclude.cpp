#include "tools/diagnose/verdict/conclude.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/explain/incidence.h"

namespace sanso::diagnose {
namespace {

const Candidate& candidate(const Library& library, int i) {
  return library.candidates[static_cast<std::size_t>(i)];
}

std::map<std::string, VerdictParameter> parameters_of(const Candidate& c,
                                                      const std::vector<double>& theta,
                                                      const Accepted& entry) {
  std::map<std::string, VerdictParameter> out;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const CandidateParameter& p = c.parameters[i];
    VerdictParameter v{theta[i], theta[i], theta[i], p.unit, false};
    if (c.random && i == 0) v.at_bound = theta[i] >= p.high * (1.0 - 1e-6);
    if (c.random && i == 0)
      v.low = std::max(p.low, entry.low), v.high = std::min(p.high, entry.high);
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
  return larger.where == chosen.where && std::find(larger.contains.begin(), larger.contains.end(),
                                                   chosen.effect) != larger.contains.end();
}

/// A spring and a ripple make any smooth torque of the angle, two masses any load of one joint: the
/// terms of a series are no causes.
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
    const bool in_a_regime = row.residual.signal == Signal::q && !row.residual.regime.empty();
    if (in_a_regime && (best == nullptr || row.predicted > best->predicted)) best = &row;
  }
  return best == nullptr ? "everywhere" : best->residual.regime;
}

}  // namespace

unsigned terms_of(const Candidate& c, const std::vector<TreeJoint>& tree) {
  const Effect* effect = find_effect(c.effect);
  if (effect == nullptr || c.joints.empty()) return 0;
  const bool on_base = std::all_of(c.joints.begin(), c.joints.end(), [&](int j) {
    return tree[static_cast<std::size_t>(j)].parent < 0;
  });
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

std::vector<Finding> findings_of(const Library& library, const Selection& selection,
                                 const Regimes& regimes) {
  std::vector<Finding> out;
  std::vector<const Candidate*> candidates;  // by finding
  const DecisionSettings& settings = selection.around->settings().decisions;
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
      const bool level = a.behind < std::max(settings.standard_errors * a.behind_se + kNoiseUnit,
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

void add_limits(Verdict& verdict, const Library& library, const Selection& selection) {
  const Screening& screening = selection.first;
  const double testable = selection.around->settings().decisions.testable;
  // effect -> noise levels that its largest probe makes
  std::map<std::string, double> best_signature;
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
    verdict.detectable.push_back({c.effect, where.empty() ? "robot" : where, c.parameters[0].name,
                                  c.parameters[0].unit, smallest});
  }
  for (const auto& [effect, signature] : best_signature) {
    if (signature >= testable) continue;
    verdict.untestable.push_back(
        {effect,
         fmt::format(
             "a typical size changes these recordings by {:.2g} noise levels only (needs {})",
             signature, testable)});
  }
}

}  // namespace sanso::diagnose
