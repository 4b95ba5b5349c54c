// The order of the steps, and the patched model.
#include "tools/diagnose/run/predict_effort.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/files/input_error.h"
#include "tools/diagnose/effects/effort_only.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/run/settings_page.h"
#include "tools/diagnose/verdict/conclude.h"

namespace sanso::diagnose {
namespace {

EffortDiagnosis refused_effort(std::vector<Defect> defects) {
  Evidence evidence;
  evidence.defects = std::move(defects);
  EffortDiagnosis out;
  out.verdict = conclude(evidence);
  return out;
}

/// Size of a term, to tell the largest of several ripples.
double size_of(const JudgedTerm& t) {
  double sum = 0.0;
  for (const JudgedValue& v : t.values) sum += v.value * v.value;
  return sum;
}

/// The effect that can be a constant torque alone.
const Effect& constant_torque() {
  const std::vector<Effect>& all = library();
  return *std::find_if(all.begin(), all.end(),
                       [](const Effect& e) { return e.effort.constant.has_value(); });
}

/// The entry of model.toml for a term; empty id: there is none.
EffectEntry entry_for(const JudgedTerm& t) {
  const double first = t.values.front().value;
  if (t.term.effect == kEffortOffset.id) {
    const Effect& effect = constant_torque();
    std::vector<double> theta = effect.null();
    theta[*effect.effort.constant] = -first;
    return entry_of({&effect, t.term.where, theta});
  }
  EffectEntry entry;
  const Effect* effect = find_effect(t.term.effect);
  if (effect == nullptr) return entry;
  entry = entry_of({effect, t.term.where, effect->null()});
  const auto named = [&](std::size_t parameter) -> double& {
    return entry.parameters[std::string(effect->parameters[parameter].name)];
  };
  if (effect->effort.kind == EffortKind::share) {
    named(effect->effort.values.front()) = 1.0 / (1.0 + first);
    return entry;
  }
  for (std::size_t c = 0; c < t.values.size(); ++c)
    named(effect->effort.values[c]) = t.values[c].value;
  for (const auto& [name, value] : t.term.fixed) entry.parameters[name] = value;
  return entry;
}

/// A term as it was chosen, without an interval.
Finding accepted(const JudgedTerm& t) {
  Finding f;
  f.effect = t.term.effect, f.family = t.term.family, f.where = t.term.where;
  f.regime = "everywhere";
  f.status = VerdictStatus::unfinished;
  f.one_of = {t.term.effect};
  for (std::size_t c = 0; c < t.values.size(); ++c) {
    const JudgedValue& v = t.values[c];
    f.parameters[t.term.parameters[c]] = {v.value, v.low, v.high, v.unit, false};
  }
  for (const auto& [name, value] : t.term.fixed)
    f.parameters[name] = {value, value, value, "-", false};
  return f;
}

}  // namespace

EffortPatch effort_patched(const ModelFolder& model, const EffortOutcome& outcome) {
  EffortPatch out{model, {}};
  for (const JudgedTerm& t : outcome.terms) {
    if (!t.predicts) continue;
    const EffectEntry entry = entry_for(t);
    // a joint of the simulator has one ripple of a kind
    const bool smaller =
        std::any_of(outcome.terms.begin(), outcome.terms.end(), [&](const JudgedTerm& other) {
          return &other != &t && other.term.effect == t.term.effect &&
                 other.term.where == t.term.where && size_of(other) > size_of(t);
        });
    if (entry.id.empty() || smaller)
      out.notes.push_back(in_words(t.term) +
                          ": found, but not in model/, the simulator has no such");
    else
      out.model.effects.push_back(entry);
  }
  return out;
}

EffortDiagnosis EffortSoFar::diagnosis(double seconds) const {
  Evidence evidence;
  evidence.unfinished = Unfinished{asking, seconds, removed};
  evidence.notes = notes;
  evidence.data_hash = data_hash;
  evidence.seed = seed;
  for (const JudgedTerm& t : terms) evidence.findings.push_back(accepted(t));
  EffortDiagnosis out;
  out.verdict = conclude(evidence);
  return out;
}

EffortDiagnosis diagnose_effort(const DiagnoseOptions& options, const Progress& progress,
                                EffortSoFar* so_far) {
  require_in_range(options.settings);
  EffortSoFar kept;
  EffortSoFar& now = so_far != nullptr ? *so_far : kept;
  now.seed = options.seed;
  const auto ask = [&](const std::string& question) {
    now.asking = question;
    progress("asks: " + question);
  };
  try {
    const ModelFolder model = read_model_folder(options.model);
    require_fixed_base(model, "sanso diagnose --predict effort");
    ask("are the recordings sound?");
    const LoadedRecordings loaded =
        load_recordings(options.recordings, gate_joints(model), options.settings.gate);
    if (loaded.gate.refused()) return refused_effort(loaded.gate.defects);
    now.notes = loaded.gate.notes, now.data_hash = loaded.hashes;
    ask("how did the joints move, and what effort did the model need for it?");
    const EffortRows rows =
        effort_rows(model, loaded.recordings, options.free_gain, options.settings);
    progress(fmt::format("{} windows of effort in {} blocks", rows.rows.size(), rows.blocks));
    ask("which terms predict effort that they were not fitted to?");
    EffortDiagnosis out;
    ChooseOptions how{options.effects, options.without, options.seed, progress};
    how.reached = [&](const std::vector<JudgedTerm>& terms, double removed) {
      now.terms = terms, now.removed = removed;
    };
    out.outcome = explain_effort(rows, options.settings, how);
    ask("what do they predict on data that were not fitted, and is anything left?");
    out.verdict = effort_verdict(out.outcome, rows, options);
    out.verdict.notes.insert(out.verdict.notes.begin(), loaded.gate.notes.begin(),
                             loaded.gate.notes.end());
    out.verdict.data_hash = loaded.hashes;
    EffortPatch patch = effort_patched(model, out.outcome);
    out.patched = std::move(patch.model);
    out.verdict.notes.insert(out.verdict.notes.end(), patch.notes.begin(), patch.notes.end());
    return out;
  } catch (const files::InputError& error) {
    return refused_effort({defect_of(error)});
  }
}

}  // namespace sanso::diagnose
