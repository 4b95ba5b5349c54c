// Statuses, and the answer in one sentence.
#include "tools/diagnose/verdict/conclude.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tools/diagnose/verdict/outlook.h"
#include "tools/diagnose/verdict/plain_words.h"

namespace sanso::diagnose {
namespace {

/// The answer but for what is described or was refuted.
std::string names(const std::vector<Finding>& findings, const std::optional<Unexplained>& unnamed) {
  if (findings.empty() && !unnamed)
    return "No mismatch found beyond noise and the nominal model's tolerances.";
  if (findings.empty()) {
    return "Physics is missing, but no name of the library passes every gate: " + unnamed->where +
           " (" + unnamed->regime + ").";
  }
  std::string text = "Missing: ";
  for (std::size_t i = 0; i < findings.size(); ++i)
    text += (i == 0 ? "" : "; ") + sentence(findings[i]);
  if (!unnamed) return text + ".";
  return text + fmt::format("; {:.0f} % of the error beyond noise stays without a name.",
                            100 * unnamed->energy_share);
}

std::string answer(const Evidence& evidence, const std::optional<Unexplained>& unnamed) {
  std::string text = names(evidence.findings, unnamed);
  std::string described;
  for (const auto& some : {evidence.search.described, evidence.search.doubtful})
    for (const std::string& d : some) described += (described.empty() ? "" : "; ") + d;
  if (!described.empty()) text += " Described, not explained, by " + described + ".";
  if (evidence.findings.empty() && !evidence.search.refuted.empty())
    text += " Not " + evidence.search.refuted.front() + ", though predictions gain from it.";
  return text;
}

std::string note_on_what_is_left(const Remains& left, const DecisionSettings& decisions) {
  const Predictability* torque = most_predictable(left.torque, decisions);
  return fmt::format(
      "left: {:.1f} % of the position error beyond noise, {:.2f} noise levels, "
      "predictable {:.0f} %",
      100 * left.share, left.level, torque != nullptr ? 100 * torque->explained : 0.0);
}

Verdict refusal(const std::vector<Defect>& defects) {
  Verdict out;
  out.status = VerdictStatus::refused;
  const Defect& first = defects.front();
  out.answer = "Refused: " + first.file + (first.channel.empty() ? "" : ", " + first.channel) +
               (first.row >= 0 ? fmt::format(", row {}", first.row) : "") + ": " + first.defect +
               " (" + first.message + ").";
  out.refused = defects;
  out.summary = plain_words(out);
  return out;
}

/// Accepted, and not judged to the end: no name is confirmed, and none is missing.
Verdict stopped(const Evidence& evidence) {
  Verdict out;
  out.status = VerdictStatus::unfinished;
  out.unfinished = evidence.unfinished;
  out.findings = evidence.findings;
  out.mismatch = evidence.search.detected || !evidence.findings.empty();
  out.answer = fmt::format("Unfinished after {:.0f} s", evidence.unfinished->seconds);
  for (std::size_t i = 0; i < evidence.findings.size(); ++i)
    out.answer += (i == 0 ? "; accepted so far: " : "; ") + sentence(evidence.findings[i]);
  out.answer += evidence.findings.empty() ? "; nothing accepted yet." : ".";
  out.untestable = evidence.untestable;
  out.notes = evidence.notes;
  out.data_hash = evidence.data_hash;
  out.seed = evidence.seed;
  out.summary = plain_words(out);
  return out;
}

/// What a tolerance explains is told in a note and is no finding.
Evidence without_tolerated(Evidence evidence) {
  for (const Finding& f : evidence.findings) {
    if (f.tolerated) evidence.notes.push_back("within tolerance: " + sentence(f));
  }
  std::erase_if(evidence.findings, [](const Finding& f) { return f.tolerated; });
  return evidence;
}

/// What may be nothing improves a prediction and names no cause: it is told as a description. Where
/// most shots agree that something of the kind is there, or most of the error goes with it (a stop
/// that few shots touch), only its size is in doubt. Two figures may
/// each be nothing and not both; one, where nothing else was found, says of no mismatch.
Evidence without_what_may_be_nothing(Evidence evidence) {
  const auto may_be_nothing = [&](const Finding& f) {
    return f.spans_null && f.agreed_low < evidence.decisions.mostly_agree &&
           f.heldout_gain < evidence.decisions.stand_in_share;
  };
  const bool one_figure =
      evidence.findings.size() == 1 && evidence.findings.front().parameters.size() == 1;
  for (const Finding& f : evidence.findings) {
    if (!may_be_nothing(f)) continue;
    (one_figure ? evidence.search.doubtful : evidence.search.described).push_back(sentence(f));
  }
  std::erase_if(evidence.findings, may_be_nothing);
  return evidence;
}

/// Share of the held-out error that descriptions remove: what they stand for has no name either.
double described(const Evidence& evidence) {
  const std::optional<Outlook> o =
      outlook(evidence.proof.scores, evidence.unit, evidence.remains, evidence.decisions);
  return o ? std::max(0.0, o->patched_share - o->named_share) : 0.0;
}

/// A law that the library lacks is taken apart into names that it has. Where they leave much of it
/// without a name, none of them is sure; what is unsure for a reason of its own keeps that. Chance
/// scatters as far as any error, given a size: beside it nothing stays that is more than noise, or
/// it is not what was missing.
Evidence doubted_beside_much(Evidence evidence) {
  const DecisionSettings& decisions = evidence.decisions;
  if (evidence.left.level <= decisions.adequate) return evidence;
  const double stays = evidence.left.share, has_no_name = stays + described(evidence);
  for (Finding& f : evidence.findings) {
    const bool unsure = f.status == VerdictStatus::present_unnamed;
    if (!f.chance && (unsure ? stays : has_no_name) <= decisions.much_left) continue;
    f.beside_much = true;
    f.status = status_of(f);
  }
  return evidence;
}

}  // namespace

Verdict conclude(const Evidence& all) {
  if (!all.defects.empty()) return refusal(all.defects);
  const Evidence evidence =
      doubted_beside_much(without_what_may_be_nothing(without_tolerated(all)));
  if (evidence.unfinished) return stopped(evidence);
  Verdict out;
  out.unexplained = unexplained(evidence);
  out.status = overall_status(evidence.findings, out.unexplained.has_value());
  out.mismatch = out.status != VerdictStatus::absent;
  out.answer = answer(evidence, out.unexplained);
  out.findings = evidence.findings;
  out.locations = evidence.before.cells;
  out.heldout = evidence.proof.scores;
  out.heldout_recordings = evidence.proof.recordings;
  out.heldout_last_part = evidence.proof.last_part;
  out.untestable = evidence.untestable;
  out.detectable = evidence.detectable;
  out.next_experiment = evidence.next_experiment;
  out.stretches = evidence.left.stretches;
  out.disagreements = evidence.disagreements;
  out.notes = evidence.notes;
  out.notes.insert(out.notes.end(), out.disagreements.begin(), out.disagreements.end());
  out.notes.push_back(note_on_what_is_left(evidence.left, evidence.decisions));
  out.data_hash = evidence.data_hash;
  out.seed = evidence.seed;
  out.outlook = outlook(evidence.proof.scores, evidence.unit, evidence.remains, evidence.decisions);
  out.summary = plain_words(out);
  return out;
}

}  // namespace sanso::diagnose
