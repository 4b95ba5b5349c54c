// The page and the table of `--predict effort`.
#include <fmt/format.h>

#include "tools/diagnose/run/predict_effort.h"
#include "tools/diagnose/run/report_sections.h"
#include "tools/diagnose/run/report_words.h"

namespace sanso::diagnose {
namespace {

void tell_findings(report::HtmlPage& page, const Verdict& v) {
  report::Table table{
      {"what", "where", "status", "parameter", "value", "95 %", "unit", "held-out gain"}, {}};
  for (const Finding& f : v.findings) {
    for (const auto& [name, p] : f.parameters) {
      table.rows.push_back({joined(f.one_of, ""), joined(f.where, ""), to_string(f.status), name,
                            fmt::format("{:.4g}", p.value),
                            fmt::format("{:.4g} to {:.4g}", p.low, p.high), p.unit,
                            fmt::format("{:.1f} %", 100 * f.heldout_gain)});
    }
  }
  if (!table.rows.empty()) page.table(table);
}

void tell_scores(report::HtmlPage& page, const EffortDiagnosis& d) {
  page.heading("Proof on data that were not fitted: " +
               joined(d.verdict.heldout_recordings, "none"));
  page.paragraph(
      "RMS of the effort that each model misses. A constant is the mean of the fitted part: a "
      "model that does not beat it explains nothing.");
  report::Table table{
      {"effort", "nominal", "a constant", "none", "named", "patched", "noise", "unit"}, {}};
  for (const EffortScore& s : d.outcome.scores) {
    table.rows.push_back({s.channel, fmt::format("{:.4g}", s.nominal),
                          fmt::format("{:.4g}", s.constant), fmt::format("{:.4g}", s.zero),
                          fmt::format("{:.4g}", s.named), fmt::format("{:.4g}", s.patched),
                          fmt::format("{:.2g}", s.noise), s.unit});
  }
  page.table(table);
}

}  // namespace

std::string effort_table(const EffortOutcome& outcome) {
  std::string out =
      fmt::format("{:<11}{:<18}{:>10}{:>12}{:>10}{:>10}{:>10}{:>10}\n", "held out", "effort",
                  "nominal", "a constant", "none", "named", "patched", "noise");
  for (const EffortScore& s : outcome.scores) {
    out +=
        fmt::format("{:<11}{:<18}{:>10.4g}{:>12.4g}{:>10.4g}{:>10.4g}{:>10.4g}{:>10.2g} {}\n", "",
                    s.channel, s.nominal, s.constant, s.zero, s.named, s.patched, s.noise, s.unit);
  }
  return out;
}

std::string effort_report(const EffortDiagnosis& d) {
  const Verdict& v = d.verdict;
  report::HtmlPage page("Diagnosis of the effort: model versus recording");
  page.paragraph("Question: the motion is given; what is missing in the effort that it took?");
  page.paragraph(v.summary);
  page.answer(fmt::format("{}: {}", to_string(v.status), v.answer),
              v.status == VerdictStatus::absent);
  if (v.status == VerdictStatus::refused) {
    tell_refusal(page, v);
    return page.finish();
  }
  tell_findings(page, v);
  tell_scores(page, d);
  tell_unexplained(page, v);
  tell_log(page, v, d.outcome.log);
  return page.finish();
}

}  // namespace sanso::diagnose
