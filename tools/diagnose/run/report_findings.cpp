// Report: why the recordings cannot be used, or why a finding has its name.
#include "tools/diagnose/run/report_sections.h"

#include <fmt/format.h>

#include "tools/diagnose/effects/parameter_of.h"
#include "tools/diagnose/run/report_words.h"

namespace sanso::diagnose {
namespace {

void add_parameters(report::HtmlPage& page, const Finding& f) {
  report::Table parameters{{"parameter", "value", "95 % interval", "unit"}, {}};
  for (const auto& [name, p] : f.parameters) {
    if (is_off(f.effect, name, p.value)) {
      parameters.rows.push_back({name, "off", "", ""});
      continue;
    }
    parameters.rows.push_back({name, fmt::format("{:.4g}", p.value),
                               p.low == p.high ? "fixed by the form"
                                               : fmt::format("{:.4g} to {:.4g}", p.low, p.high) +
                                                     (p.at_bound ? ", at the bound" : ""),
                               p.unit});
  }
  page.table(parameters);
}

void add_promises(report::HtmlPage& page, const Finding& f) {
  if (f.incidence.empty()) return;
  report::Table promised{
      {"what it promised to change", "size, noise levels", "share that happened", "95 % interval"},
      {}};
  for (const IncidenceRow& row : f.incidence) {
    promised.rows.push_back({to_string(row.residual), fmt::format("{:.0f}", row.predicted),
                             fmt::format("{:.0f} %", 100 * row.slope),
                             fmt::format("{:.0f} to {:.0f} %", 100 * row.low, 100 * row.high)});
  }
  page.paragraph(
      "An explanation is refuted when a change that it promises did not happen (interval below 50 "
      "%) or happened twice "
      "over.");
  page.table(promised);
}

void add_rivals(report::HtmlPage& page, const Finding& f) {
  report::Table rivals{{"rival", "where", "held-out gain", "behind, standard errors",
                        "similar signature", "what it said wrong"},
                       {}};
  for (const Rival& r : f.rivals) {
    rivals.rows.push_back(
        {r.effect, joined(r.where, "robot"), fmt::format("{:.0f} %", 100 * r.heldout_gain),
         fmt::format("{:.1f}", r.behind_in_se), fmt::format("{:.2f}", r.similarity),
         r.said_wrong.empty() ? "nothing that these data show" : r.said_wrong});
  }
  if (!rivals.rows.empty()) page.table(rivals);
}

}  // namespace

void tell_refusal(report::HtmlPage& page, const Verdict& v) {
  report::Table table{{"file", "channel", "row", "defect", "what was seen"}, {}};
  for (const Defect& d : v.refused) {
    table.rows.push_back(
        {d.file, d.channel, d.row >= 0 ? std::to_string(d.row) : "all", d.defect, d.message});
  }
  page.heading("Why these data cannot be used");
  page.table(table);
}

void tell_finding(report::HtmlPage& page, const Finding& f) {
  page.heading("Why " + in_words(f.effect) + " at " + joined(f.where, "the whole robot") +
               ", and not its rivals");
  page.paragraph(fmt::format(
      "Removes {:.0f} % (standard error {:.0f} %) of the whole prediction error on held-out data; "
      "family-wise p = {:.3g}; "
      "shows most: {}.",
      100 * f.heldout_gain, 100 * f.heldout_gain_se, f.p_family, f.regime));
  add_parameters(page, f);
  add_promises(page, f);
  add_rivals(page, f);
}

}  // namespace sanso::diagnose
