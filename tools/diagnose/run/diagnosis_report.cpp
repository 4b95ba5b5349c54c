// The report of a diagnosis: the answer first, then the sections that argue for it.
#include "tools/diagnose/run/diagnosis_report.h"

#include <fmt/format.h>

#include <span>

#include "tools/diagnose/run/report_sections.h"
#include "tools/diagnose/run/report_words.h"

namespace sanso::diagnose {
namespace {

const char* meaning(VerdictStatus status) {
  switch (status) {
    case VerdictStatus::confirmed:
      return "Every name below passed every gate: it predicts data that were not fitted, its "
             "rivals do not, and what "
             "it promised happened.";
    case VerdictStatus::one_of:
      return "Something is missing for certain. Where a set is given, these data cannot tell its "
             "members apart; see "
             "what to record next.";
    case VerdictStatus::present_unnamed:
      return "Something is missing that the names below explain in part or not at all. Read the "
             "shape curves.";
    case VerdictStatus::absent:
      return "Nothing stands out of noise and of what a nominal model may be wrong by. The end of "
             "the page lists how "
             "small an effect would have been seen.";
    case VerdictStatus::refused:
      return "The recordings are broken. Nothing was fitted.";
    case VerdictStatus::unfinished:
      return "The run was ended early. The names below were accepted until then; they were not "
             "tried against their look-alikes, and nothing was scored on held-out recordings.";
  }
  return "";
}

/// The answer in figures: error on held-out data before and after, at the shortest horizon of half
/// a second or more.
void tell_summary(report::HtmlPage& page, const Diagnosis& d) {
  const Verdict& v = d.verdict;
  page.paragraph(meaning(v.status));
  for (const double seconds : std::span(kHorizons_s).subspan(1)) {
    const Horizon horizon = Horizon::ahead(seconds);
    const auto at = v.heldout.find(horizon);
    if (at == v.heldout.end() || !at->second.all) continue;
    const FitScore& s = *at->second.all;
    page.paragraph(fmt::format(
        "On recordings that were not fitted, {} s ahead, the error {} from {:.3g} to {:.3g} {} "
        "(measurement noise "
        "{:.2g}): {:.0f} % of the error beyond noise is explained.",
        horizon.text(), s.patched < s.nominal ? "falls" : "goes", s.nominal, s.patched,
        position_unit(d), s.noise, 100 * s.explained()));
    return;
  }
}

}  // namespace

std::string diagnosis_report(const Diagnosis& d) {
  const Verdict& v = d.verdict;
  report::HtmlPage page("Diagnosis: simulation versus recording");
  page.paragraph(
      "Question: where do simulation and recording part, what physics is missing, and does adding "
      "it help on data not "
      "used?");
  page.answer(fmt::format("{}: {}", to_string(v.status), v.answer),
              v.status == VerdictStatus::absent);
  page.paragraph(v.summary);
  tell_summary(page, d);
  if (v.status == VerdictStatus::refused) {
    tell_refusal(page, v);
    return page.finish();
  }
  if (d.patched) tell_robot(page, v, *d.patched, {d.motions, true, {}});
  const bool finished = v.status != VerdictStatus::unfinished;
  if (finished) tell_where(page, d);
  for (const Finding& f : v.findings) tell_finding(page, f);
  if (finished) {
    tell_curves(page, d);
    tell_proof(page, d);
    tell_unexplained(page, v);
    tell_next_experiment(page, v);
  }
  tell_limits(page, v);
  tell_log(page, v, d.log);
  return page.finish();
}

}  // namespace sanso::diagnose
