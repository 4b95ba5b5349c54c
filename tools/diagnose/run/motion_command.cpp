// `sanso diagnose`: what the terminal and verdict.txt say of a diagnosis.
#include <fmt/format.h>

#include <cmath>

#include "tools/diagnose/effects/parameter_of.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/run/diagnosis_report.h"
#include "tools/diagnose/run/ending.h"
#include "tools/diagnose/run/report_words.h"
#include "tools/diagnose/wholebody/diagnose_whole.h"

namespace sanso::diagnose {
namespace {

std::string finding_text(const Finding& f) {
  std::string out;
  for (const auto& [name, p] : f.parameters) {
    if (is_off(f.effect, name, p.value)) {
      out += fmt::format("           {}.{}: off\n", f.effect, name);
      continue;
    }
    out += fmt::format("           {}.{} = {:.4g} {} [{:.4g}, {:.4g}]{}\n", f.effect, name, p.value,
                       p.unit, p.low, p.high, p.at_bound ? " (at the library's bound)" : "");
  }
  for (const Rival& r : f.rivals) {
    out += r.said_wrong.empty()
               ? fmt::format("not        {}: {:.1f} standard errors behind on held-out data\n",
                             r.effect, r.behind_in_se)
               : fmt::format("not        {}: {}\n", r.effect, r.said_wrong);
  }
  return out;
}

std::string proof_text(const Verdict& v) {
  std::string out;
  for (const auto& [horizon, scores] : v.heldout) {
    if (!scores.all) continue;
    const FitScore& s = *scores.all;
    out += fmt::format(
        "held out   {} s: {:.4g} -> {:.4g} (noise {:.2g}; going on as it went {:.4g}; named alone "
        "{:.4g})\n",
        horizon.text(), s.nominal, s.patched, s.noise, s.baseline, s.named);
  }
  return out;
}

std::string text_of(const Verdict& v) {
  std::string out = wrapped(v.summary, 96) + "\n";
  out += "question   where do simulation and recording part, and what is missing?\n";
  out += fmt::format("answer     {}: {}\n", to_string(v.status), v.answer);
  for (const Defect& d : v.refused) {
    out += fmt::format("refused    {} {}{}: {}: {}\n", d.file, d.channel,
                       d.row >= 0 ? fmt::format(" row {}", d.row) : "", d.defect, d.message);
  }
  if (v.status == VerdictStatus::refused) return out;
  for (const Finding& f : v.findings) out += finding_text(f);
  out += proof_text(v);
  if (v.next_experiment) out += fmt::format("next       {}\n", v.next_experiment->what);
  return out;
}

Ending ending_of(Diagnosis d) {
  Ending out;
  out.text = text_of(d.verdict);
  out.report = diagnosis_report(d);
  out.verdict = std::move(d.verdict);
  out.patched = std::move(d.patched);
  return out;
}

}  // namespace

int run_diagnose(const DiagnoseOptions& options) {
  if (floats(options.model)) return run_diagnose_whole(options);
  SoFar so_far;
  return run_command(
      options,
      {[&](const Progress& progress) { return ending_of(diagnose(options, progress, &so_far)); },
       [&](double seconds) { return ending_of(so_far.diagnosis(seconds)); }});
}

}  // namespace sanso::diagnose
