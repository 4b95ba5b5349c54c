#include "tools/diagnose/verdict/decide.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/verdict/conclude.h"

namespace sanso::diagnose {
namespace {

/// Some candidate stood out in the first screening: the error is no noise, whether or not a name
/// passed the later gates.
bool detected(const Selection& selection) {
  const double level = selection.around->settings().decisions.family_wise;
  return std::any_of(selection.first.probes.begin(), selection.first.probes.end(),
                     [level](const ProbeScore& p) { return p.p_family < level; });
}

/// The joint whose remaining error is most surely physics: predictable, and larger than noise makes
/// it.
const Predictability* most_predictable(const DecisionSettings& settings,
                                       const std::vector<Predictability>& left) {
  const Predictability* best = nullptr;
  const double level =
      settings.family_wise / static_cast<double>(std::max<std::size_t>(1, left.size()));
  for (const Predictability& p : left) {
    // p resolves to 1 / (bootstrap + 1); with many joints the smallest p is all one can ask for
    const bool significant = p.p <= std::max(level, 1.0 / (settings.bootstrap + 1.0) + 1e-12);
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

/// Effects that stay in the model as a description though a residual speaks against them; empty:
/// none.
std::string stand_ins(const Library& library, const Selection& selection) {
  std::string text;
  for (const Accepted& entry : selection.accepted) {
    if (entry.contradicted.empty()) continue;
    text += (text.empty() ? "" : "; ") +
            library.candidates[static_cast<std::size_t>(entry.candidate)].title() + " (" +
            entry.contradicted + ")";
  }
  return text;
}

/// What of the data stays without a name, and how that shows; empty: nothing beyond noise.
std::optional<Unexplained> unexplained(const Verdict& verdict, const Problem& problem,
                                       const Selection& selection, const Remains& left,
                                       const std::string& location) {
  Unexplained u;
  u.energy_share = remaining_share(problem, selection);
  u.regime = location;
  const auto name = [&](int joint) { return problem.joints[static_cast<std::size_t>(joint)]; };
  const DecisionSettings& settings = problem.settings.decisions;
  const Predictability* torque = most_predictable(settings, left.torque);
  const Predictability* velocity = most_predictable(settings, left.velocity);
  for (const Predictability* p : {torque, velocity}) {
    if (p == nullptr) continue;
    u.predictable = p->explained;
    u.p = p->p;
    u.where = name(p->joint);
    u.shows_in = p == torque ? ShowsIn::torque : ShowsIn::velocity_channel;
    if (p == velocity) u.regime = "velocity channel against the motion of the position channel";
    return u;
  }
  if (left.stretches_matter) {
    u.where = name(left.stretches_joint);
    u.shows_in = ShowsIn::stretches;
    u.regime = "in " + std::to_string(verdict.stretches.size()) + " short stretches";
    return u;
  }
  // however loud the effects that have a name were: what is left besides is no noise
  const double level =
      position_error_level(*selection.around, selection.final.r, selection.expected_scatter);
  const bool inadequate = level > settings.adequate && detected(selection);
  const bool stopped =
      std::any_of(verdict.findings.begin(), verdict.findings.end(),
                  [](const Finding& f) { return f.status == VerdictStatus::present_unnamed; });
  const bool described = std::any_of(selection.accepted.begin(), selection.accepted.end(),
                                     [](const Accepted& a) { return !a.contradicted.empty(); });
  // held-out predictions improved beyond chance: something is there, if not what was tried
  const bool refuted = verdict.findings.empty() && !selection.refuted.empty();
  if (!inadequate && !stopped && !described && !refuted) return std::nullopt;
  u.where = verdict.locations.empty() ? problem.joints.front() : verdict.locations.front().where;
  u.shows_in = ShowsIn::position;
  return u;
}

VerdictStatus status_of(const Verdict& verdict) {
  if (verdict.unexplained) return VerdictStatus::present_unnamed;
  if (verdict.findings.empty()) return VerdictStatus::absent;
  const bool several =
      std::any_of(verdict.findings.begin(), verdict.findings.end(),
                  [](const Finding& f) { return f.status == VerdictStatus::one_of; });
  return several ? VerdictStatus::one_of : VerdictStatus::confirmed;
}

std::string answer(const Verdict& verdict) {
  if (verdict.status == VerdictStatus::absent)
    return "No mismatch found beyond noise and the nominal model's tolerances.";
  if (verdict.findings.empty()) {
    return "Physics is missing, but no name of the library passes every gate: " +
           verdict.unexplained->where + " (" + verdict.unexplained->regime + ").";
  }
  std::string text = "Missing: ";
  for (std::size_t i = 0; i < verdict.findings.size(); ++i)
    text += (i == 0 ? "" : "; ") + sentence(verdict.findings[i]);
  if (verdict.status != VerdictStatus::present_unnamed) return text + ".";
  return text + fmt::format("; {:.0f} % of the error beyond noise stays without a name.",
                            100 * verdict.unexplained->energy_share);
}

}  // namespace

void decide(Verdict& verdict, const Problem& problem, const Library& library,
            const Selection& selection, const Remains& left, const std::string& location) {
  const Predictability* torque = most_predictable(problem.settings.decisions, left.torque);
  verdict.notes.push_back(fmt::format(
      "left: {:.1f} % of the position error beyond noise, {:.2f} noise levels, "
      "predictable {:.0f} %",
      100 * remaining_share(problem, selection),
      position_error_level(*selection.around, selection.final.r, selection.expected_scatter),
      torque != nullptr ? 100 * torque->explained : 0.0));
  verdict.unexplained = unexplained(verdict, problem, selection, left, location);
  verdict.status = status_of(verdict);
  verdict.mismatch = verdict.status != VerdictStatus::absent;
  verdict.answer = answer(verdict);
  if (const std::string described = stand_ins(library, selection); !described.empty())
    verdict.answer += " Described, not explained, by " + described + ".";
  if (verdict.findings.empty() && !selection.refuted.empty())
    verdict.answer += " Not " + selection.refuted.front() + ", though predictions gain from it.";
}

}  // namespace sanso::diagnose
