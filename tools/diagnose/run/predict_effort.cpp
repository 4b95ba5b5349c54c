// The order of the steps, the patched model, and the command around them.
#include "tools/diagnose/run/predict_effort.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/run/settings_page.h"
#include "tools/diagnose/verdict/conclude.h"

namespace sanso::diagnose {
namespace {

EffortDiagnosis refused(std::vector<Defect> defects) {
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

/// The entry of model.toml for a term; empty id: there is none.
EffectEntry entry_for(const JudgedTerm& t) {
  EffectEntry entry;
  entry.where = t.term.where;
  if (t.term.effect == kEffortOffset) {
    entry.id = "cable_spring";
    entry.parameters = {{"stiffness", 0.0}, {"torque", -t.values.front().value}};
  } else if (t.term.effect == "torque_constant") {
    entry.id = t.term.effect;
    entry.parameters = {{"torque", 1.0 / (1.0 + t.values.front().value)}, {"resistance", 1.0}};
  } else if (find_effect(t.term.effect) != nullptr) {
    entry.id = t.term.effect;
    for (std::size_t c = 0; c < t.values.size(); ++c)
      entry.parameters[t.term.parameters[c]] = t.values[c].value;
    for (const auto& [name, value] : t.term.fixed) entry.parameters[name] = value;
  }
  return entry;
}

void write_all(const EffortDiagnosis& d, const std::string& out) {
  std::filesystem::create_directories(out);
  const std::filesystem::path folder(out);
  if (d.patched) write_model_folder(*d.patched, (folder / "model").string());
  files::write_atomically(folder / "report.html", effort_report(d));
  // last: it says that the others are there
  files::write_atomically(folder / "verdict.json", verdict_json(d.verdict));
}

void print_summary(const EffortDiagnosis& d) {
  const Verdict& v = d.verdict;
  fmt::print("question   the motion is given: what is missing in the effort?\n");
  fmt::print("answer     {}: {}\n", to_string(v.status), v.answer);
  for (const Defect& r : v.refused)
    fmt::print("refused    {} {}: {}: {}\n", r.file, r.channel, r.defect, r.message);
  if (v.status == VerdictStatus::refused) return;
  for (const Finding& f : v.findings) {
    std::string places;
    for (const std::string& w : f.where) places += (places.empty() ? "" : ", ") + w;
    for (const auto& [name, p] : f.parameters) {
      fmt::print("{:<11}{}.{} at {} = {:.4g} {} [{:.4g}, {:.4g}]\n", "", f.effect, name, places,
                 p.value, p.unit, p.low, p.high);
    }
  }
  fmt::print("{}", effort_table(d.outcome));
  for (const std::string& note : v.notes) fmt::print("note       {}\n", note);
}

extern "C" void on_stop(int) { request_stop(); }

}  // namespace

ModelFolder effort_patched(const ModelFolder& model, const EffortOutcome& outcome,
                           std::vector<std::string>& notes) {
  ModelFolder out = model;
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
      notes.push_back(in_words(t.term) + ": found, but not in model/, the simulator has no such");
    else
      out.effects.push_back(entry);
  }
  return out;
}

EffortDiagnosis diagnose_effort(const DiagnoseOptions& options, const Progress& progress) {
  require_in_range(options.settings);
  try {
    const ModelFolder model = read_model_folder(options.model);
    progress("read and judge the recordings");
    const LoadedRecordings loaded = load_recordings(options.recordings, gate_joints(model));
    if (loaded.gate.refused()) return refused(loaded.gate.defects);
    progress("smooth the motion");
    const EffortRows rows =
        effort_rows(model, loaded.recordings, options.free_gain, options.settings);
    progress(fmt::format("{} windows of effort in {} blocks", rows.rows.size(), rows.blocks));
    EffortDiagnosis out;
    out.outcome = explain_effort(rows, options.settings,
                                 {options.effects, options.without, options.seed, progress});
    progress("judge on data that were not fitted");
    out.verdict = effort_verdict(out.outcome, rows, options);
    out.verdict.notes.insert(out.verdict.notes.begin(), loaded.gate.notes.begin(),
                             loaded.gate.notes.end());
    out.verdict.data_hash = data_hash(loaded.recordings);
    out.patched = effort_patched(model, out.outcome, out.verdict.notes);
    return out;
  } catch (const files::InputError& error) {
    return refused({defect_of(error)});
  }
}

int run_predict_effort(const DiagnoseOptions& options) {
  std::signal(SIGINT, on_stop);
  std::signal(SIGTERM, on_stop);
  try {
    const EffortDiagnosis d = diagnose_effort(options, [&](const std::string& line) {
      if (!options.quiet) std::fprintf(stderr, "diagnose: %s\n", line.c_str());
    });
    if (!options.out.empty()) write_all(d, options.out);
    if (options.json)
      fmt::print("{}", verdict_json(d.verdict));
    else
      print_summary(d);
    if (d.verdict.status == VerdictStatus::refused) return 2;
    return d.verdict.mismatch ? 1 : 0;
  } catch (const Interrupted&) {
    std::fprintf(stderr, "diagnose: interrupted, nothing written\n");
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diagnose: %s\n", error.what());
    return 2;
  }
}

}  // namespace sanso::diagnose
