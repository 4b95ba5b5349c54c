// Grades by shares of the error energy beyond noise, and by what the user can live with.
#include "tools/diagnose/verdict/outlook.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

/// The horizon to tell of.
HeldoutScores::const_iterator horizon_of(const HeldoutScores& scores, double users) {
  auto best = scores.end();
  for (auto it = scores.begin(); it != scores.end(); ++it) {
    if (!it->second.all) continue;
    if (best == scores.end()) {
      best = it;
      continue;
    }
    const double now = it->first.seconds(), before = best->first.seconds();
    const bool reaches = now >= users - 1e-9, reached = before >= users - 1e-9;
    if (reaches == reached ? (reaches ? now < before : now > before) : reaches) best = it;
  }
  return best;
}

Grade grade_of(const Outlook& o, double most) {
  const FitScore& s = o.score;
  // not asked: nothing to beat
  const auto loses = [&](double error) { return std::isfinite(s.baseline) && error >= s.baseline; };
  if (s.named <= o.matters_from && !loses(s.named)) return Grade::explained;
  if (o.named_share >= most && !loses(s.named)) return Grade::mostly;
  if (o.named_share > 0.0 && s.named < s.nominal) return Grade::in_part;
  return o.patched_share >= most && !loses(s.patched) ? Grade::described : Grade::located;
}

}  // namespace

const char* to_string(Grade grade) {
  switch (grade) {
    case Grade::explained:
      return "explained";
    case Grade::mostly:
      return "mostly explained";
    case Grade::in_part:
      return "explained in part";
    case Grade::described:
      return "described";
    case Grade::located:
      return "located";
  }
  return "located";
}

std::optional<Outlook> outlook(const HeldoutScores& scores, const std::string& unit,
                               const RemainsSettings& remains, const DecisionSettings& decisions) {
  const auto at = horizon_of(scores, remains.horizon);
  if (at == scores.end()) return std::nullopt;
  Outlook out;
  out.horizon = at->first;
  out.unit = unit;
  out.score = *at->second.all;
  if (!std::isfinite(out.score.named)) out.score.named = out.score.nominal;
  out.named_share = out.score.explained_by(out.score.named);
  out.patched_share = out.score.explained();
  out.matters_from = std::max(remains.matters, decisions.adequate * out.score.noise);
  out.matters = out.score.patched > out.matters_from;
  out.grade = grade_of(out, remains.most);
  return out;
}

std::string in_words(const Outlook& o) {
  std::string text = fmt::format(
      "{}: the named effects remove {:.0f} % of the error beyond noise, the whole patched model "
      "{:.0f} %; {:.3g} {} are left, {:.2g} noise levels, which {}",
      to_string(o.grade), 100 * o.named_share, 100 * o.patched_share, o.score.patched, o.unit,
      o.left_in_noise(), o.matters ? "matters" : "does not matter");
  if (o.matters) text += fmt::format(" (from {:.2g} {} on)", o.matters_from, o.unit);
  return text;
}

}  // namespace sanso::diagnose
