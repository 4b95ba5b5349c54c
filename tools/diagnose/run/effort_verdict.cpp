// Statuses, answer and what stays unnamed, on the torque side.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/effects/parameter_of.h"
#include "tools/diagnose/run/predict_effort.h"
#include "tools/diagnose/verdict/plain_words.h"
#include "tools/diagnose/verdict/predictability.h"

namespace sanso::diagnose {
namespace {

const EffortScore* score_at(const EffortOutcome& outcome, const std::string& joint) {
  for (const EffortScore& s : outcome.scores) {
    if (s.joint == joint) return &s;
  }
  return nullptr;
}

/// The finding of a term that predicts, as the other mode would say it.
Finding finding_of(const JudgedTerm& t) {
  Finding f;
  f.effect = t.term.effect;
  f.family = t.term.family;
  f.where = t.term.where;
  f.regime = "everywhere";
  f.spans_null = t.spans_null;
  f.heldout_gain = t.heldout_gain;
  f.heldout_gain_low = t.heldout_gain_low;
  f.one_of = {t.term.effect};
  for (const std::string& name : t.equally_good) f.one_of.push_back(name);
  for (std::size_t c = 0; c < t.values.size(); ++c) {
    const JudgedValue& v = t.values[c];
    // friction that is zero beside its coupled twin is no bound that was met
    const bool met = v.at_bound && v.value != 0.0;
    f.parameters[t.term.parameters[c]] = {v.value, v.low, v.high, v.unit, met};
  }
  for (const auto& [name, value] : t.term.fixed) {
    const EffectParameter* known = find_parameter(f.effect, name);
    const bool speed = known != nullptr && known->scale == Unit::speed;
    f.parameters[name] = {value, value, value, speed ? "rad/s" : "-", false};
  }
  f.status = status_of(f);
  return f;
}

TorqueSample sample_of(const EffortLeft& left, const EffortRows& rows, double noise) {
  const EffortRecording& r = rows.recordings[left.row.recording];
  const std::size_t j = left.row.joint;
  const std::size_t middle = (left.row.first + left.row.last) / 2;
  TorqueSample s;
  s.source = left.row.recording, s.joint = left.row.joint, s.row = left.row.first;
  s.t = r.t[middle];
  s.q = r.motion[middle].q[j], s.dq = r.motion[middle].dq[j], s.ddq = r.motion[middle].ddq[j];
  s.motor = left.row.effort, s.missing = left.residual, s.sigma = noise;
  return s;
}

std::vector<TorqueSample> samples_of(const EffortOutcome& outcome, const EffortRows& rows,
                                     std::size_t joint, const RemainsSettings& settings) {
  std::vector<const EffortLeft*> of;
  for (const EffortLeft& left : outcome.left) {
    if (left.row.joint == joint) of.push_back(&left);
  }
  const EffortScore* score =
      score_at(outcome, rows.recordings.front().nominal.tree.joints[joint].name);
  const std::size_t stride = of.size() / static_cast<std::size_t>(settings.effort_samples) + 1;
  std::vector<TorqueSample> out;
  for (std::size_t k = 0; k < of.size(); k += stride)
    out.push_back(sample_of(*of[k], rows, score != nullptr ? score->noise : 0.0));
  return out;
}

/// Squared held-out effort beyond noise that is left, of what the nominal model misses.
double share_left(const EffortScore& s) {
  const double before = s.nominal * s.nominal - s.noise * s.noise;
  const double after = s.patched * s.patched - s.noise * s.noise;
  return before > 0.0 ? std::clamp(after / before, 0.0, 1.0) : 0.0;
}

/// An effort of which nothing here predicts anything, the nominal model neither: no name is missing
/// for certain, and "no mismatch" is not known.
std::optional<Unexplained> unpredicted(const EffortOutcome& outcome,
                                       const DecisionSettings& decisions) {
  const EffortScore* worst = nullptr;
  const auto level = [](const EffortScore& s) { return s.patched / std::max(s.noise, 1e-300); };
  for (const EffortScore& s : outcome.scores) {
    const bool predicted = s.patched < 0.9 * s.baseline();
    if (predicted || level(s) <= decisions.adequate) continue;
    if (worst == nullptr || level(s) > level(*worst)) worst = &s;
  }
  if (worst == nullptr) return std::nullopt;
  Unexplained u;
  u.shows_in = ShowsIn::torque;
  u.where = worst->joint;
  u.regime =
      "its recorded effort, which neither the model nor any name predicts better than a "
      "constant does";
  u.energy_share = share_left(*worst);
  return u;
}

std::optional<Unexplained> unnamed(const EffortOutcome& outcome, const EffortRows& rows,
                                   const DiagnoseOptions& options) {
  std::vector<Predictability> all;
  std::vector<std::vector<TorqueSample>> samples(rows.recordings.front().channels.size());
  for (std::size_t j = 0; j < samples.size(); ++j) {
    if (!rows.recordings.front().channels[j].known) continue;
    samples[j] = samples_of(outcome, rows, j, options.settings.remains);
    all.push_back(
        predictability(samples[j], static_cast<int>(j), Random(options.seed, j), options.settings));
  }
  const Predictability* worst = most_predictable(all, options.settings.decisions);
  if (worst == nullptr) return unpredicted(outcome, options.settings.decisions);
  const auto j = static_cast<std::size_t>(worst->joint);
  Unexplained u;
  u.shows_in = ShowsIn::torque;
  u.predictable = worst->explained, u.p = worst->p;
  u.where = rows.recordings.front().nominal.tree.joints[j].name;
  u.regime = "effort at the recorded motion";
  if (const EffortScore* s = score_at(outcome, u.where)) u.energy_share = share_left(*s);
  u.formula = sparse_formula(samples[j], worst->joint, options.settings.remains).text;
  return u;
}

std::string answer_of(const Verdict& v) {
  if (v.findings.empty() && !v.unexplained)
    return "No mismatch of the effort beyond noise and the nominal model's tolerances.";
  std::string text = v.findings.empty() ? "Effort is missing, but no name passes every gate"
                                        : "Missing in the effort: ";
  for (std::size_t i = 0; i < v.findings.size(); ++i)
    text += (i == 0 ? "" : "; ") + sentence(v.findings[i]);
  if (v.unexplained) {
    text += fmt::format("; without a name stays most at {} ({:.1f} % of what was missing there)",
                        v.unexplained->where, 100 * v.unexplained->energy_share);
  }
  return text + ".";
}

/// The joints together, as far as their efforts have the first one's unit.
FitScore together(const std::vector<EffortScore>& scores) {
  FitScore sum{0.0, 0.0, 0.0, 0.0, 0.0};
  double joints = 0.0;
  for (const EffortScore& s : scores) {
    if (s.unit != scores.front().unit) continue;
    sum.nominal += s.nominal * s.nominal, sum.patched += s.patched * s.patched;
    sum.noise += s.noise * s.noise, sum.baseline += s.baseline() * s.baseline();
    sum.named += s.named * s.named, joints += 1.0;
  }
  const auto root = [&](double x) { return std::sqrt(x / joints); };
  return {root(sum.nominal), root(sum.patched), root(sum.noise), root(sum.baseline),
          root(sum.named)};
}

HeldoutScores heldout_of(const std::vector<EffortScore>& scores) {
  HeldoutScores out;
  if (scores.empty()) return out;
  HorizonScores& here = out[Horizon::recorded_motion()];
  for (const EffortScore& s : scores)
    here.channels[s.channel] = {s.nominal, s.patched, s.noise, s.baseline(), s.named};
  here.all = together(scores);
  return out;
}

bool beaten(const EffortOutcome& outcome, const JudgedTerm& t) {
  const EffortScore* score = score_at(outcome, t.term.where.front());
  return score != nullptr && !score->beats_both();
}

bool named(const EffortOutcome& outcome, const JudgedTerm& t) {
  return t.predicts && !beaten(outcome, t);
}

std::vector<Finding> findings_of(const EffortOutcome& outcome) {
  std::vector<Finding> out;
  for (const JudgedTerm& t : outcome.terms) {
    if (named(outcome, t)) out.push_back(finding_of(t));
  }
  return out;
}

/// What describes the effort and has no name.
std::vector<std::string> notes_on_terms(const EffortOutcome& outcome) {
  std::vector<std::string> out;
  for (const JudgedTerm& t : outcome.terms) {
    if (named(outcome, t)) continue;
    out.push_back("described, not named: " + in_words(t.term) +
                  (beaten(outcome, t) ? ": the joint's effort is not predicted better than by the "
                                        "nominal model and by a constant"
                                      : ": its gain on held-out data is not beyond chance"));
  }
  return out;
}

std::vector<std::string> notes_on_scores(const std::vector<EffortScore>& scores) {
  std::vector<std::string> out;
  out.reserve(2 * scores.size());
  for (const EffortScore& s : scores) {
    out.push_back(
        fmt::format("held-out effort {}: nominal {:.4g}, a constant {:.4g}, none {:.4g}, patched "
                    "{:.4g} {}",
                    s.channel, s.nominal, s.constant, s.zero, s.patched, s.unit));
  }
  for (const EffortScore& s : scores) {
    if (s.beyond == 0) continue;
    out.push_back(
        fmt::format("{}: {} held-out windows move faster than anything fitted and do not judge",
                    s.channel, s.beyond));
  }
  return out;
}

std::vector<std::string> notes_on_gains(const std::vector<EffortGainFound>& gains) {
  std::vector<std::string> out;
  out.reserve(gains.size());
  for (const EffortGainFound& g : gains) {
    out.push_back(
        g.determined
            ? fmt::format("drive gain of {}: {:.4g} N m for 1 {} [{:.4g}, {:.4g}], a nuisance",
                          g.joint, g.value, g.unit, g.low, g.high)
            : fmt::format("drive gain of {}: not determined by these data, its efforts are in {}",
                          g.joint, g.unit));
  }
  return out;
}

}  // namespace

Verdict effort_verdict(const EffortOutcome& outcome, const EffortRows& rows,
                       const DiagnoseOptions& options) {
  Verdict v;
  v.seed = options.seed;
  v.notes = outcome.notes;
  v.disagreements = outcome.disagreements;
  for (const std::vector<std::string>& notes :
       {notes_on_terms(outcome), notes_on_scores(outcome.scores), notes_on_gains(outcome.gains)})
    v.notes.insert(v.notes.end(), notes.begin(), notes.end());
  v.findings = findings_of(outcome);
  v.heldout = heldout_of(outcome.scores);
  v.heldout_recordings = outcome.heldout_names;
  v.heldout_last_part = outcome.heldout_last_part;
  v.unexplained = unnamed(outcome, rows, options);
  v.status = overall_status(v.findings, v.unexplained.has_value());
  v.mismatch = v.status != VerdictStatus::absent;
  v.answer = answer_of(v);
  if (!outcome.scores.empty())
    v.outlook = outlook(v.heldout, outcome.scores.front().unit, options.settings.remains,
                        options.settings.decisions);
  v.summary = plain_words(v);
  return v;
}

}  // namespace sanso::diagnose
