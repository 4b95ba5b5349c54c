// `sanso diagnose --predict effort`: what the terminal and verdict.txt say, and what a run that is
// ended early has found.
#include <fmt/format.h>

#include "tools/diagnose/run/ending.h"
#include "tools/diagnose/run/predict_effort.h"
#include "tools/diagnose/run/report_words.h"
#include "tools/diagnose/verdict/plain_words.h"

namespace sanso::diagnose {
namespace {

std::string text_of(const EffortDiagnosis& d) {
  const Verdict& v = d.verdict;
  std::string out = wrapped(v.summary, 96) + "\n";
  out += "question   the motion is given: what is missing in the effort?\n";
  out += fmt::format("answer     {}: {}\n", to_string(v.status), v.answer);
  for (const Defect& r : v.refused)
    out += fmt::format("refused    {} {}: {}: {}\n", r.file, r.channel, r.defect, r.message);
  if (v.status == VerdictStatus::refused) return out;
  for (const Finding& f : v.findings) {
    for (const auto& [name, p] : f.parameters) {
      out += fmt::format("{:<11}{}.{} at {} = {:.4g} {} [{:.4g}, {:.4g}]\n", "", f.effect, name,
                         places(f.where), p.value, p.unit, p.low, p.high);
    }
  }
  if (!d.outcome.scores.empty()) out += effort_table(d.outcome);
  for (const std::string& note : v.notes) out += fmt::format("note       {}\n", note);
  return out;
}

Ending ending_of(EffortDiagnosis d) {
  Ending out;
  out.text = text_of(d);
  out.report = effort_report(d);
  out.verdict = std::move(d.verdict);
  out.patched = std::move(d.patched);
  return out;
}

}  // namespace

int run_predict_effort(const DiagnoseOptions& options) {
  EffortSoFar so_far;
  return run_command(options,
                     {[&](const Progress& progress) {
                        return ending_of(diagnose_effort(options, progress, &so_far));
                      },
                      [&](double seconds) { return ending_of(so_far.diagnosis(seconds)); }});
}

}  // namespace sanso::diagnose
