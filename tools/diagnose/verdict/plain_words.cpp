// Sentences in a fixed order; each is left out where the verdict does not know.
#include "tools/diagnose/verdict/plain_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/effects/effort_only.h"
#include "tools/diagnose/effects/parameter_of.h"

namespace sanso::diagnose {
namespace {

/// More findings than this are counted, not told.
constexpr std::size_t kTold = 6;

std::string name_of(const std::string& id) {
  if (const EffortOnly* term = find_effort_only(id)) return term->name;
  const Effect* effect = find_effect(id);
  return effect == nullptr ? id : std::string(effect->name);
}

/// "dry friction, backlash or cogging".
std::string any_of(const std::vector<std::string>& ids) {
  std::string text;
  for (std::size_t i = 0; i < ids.size(); ++i)
    text += (i == 0 ? "" : i + 1 == ids.size() ? " or " : ", ") + name_of(ids[i]);
  return text;
}

/// The fitted parameter that says most: surest to differ from nothing; nullptr: none was fitted.
const std::pair<const std::string, VerdictParameter>* telling(const Finding& f) {
  const std::pair<const std::string, VerdictParameter>* best = nullptr;
  double most = -1.0;
  for (const auto& entry : f.parameters) {
    const VerdictParameter& p = entry.second;
    if (p.low == p.high && best != nullptr) continue;  // not fitted
    if (is_off(f.effect, entry.first, p.value)) continue;
    const double sure = std::abs(p.value) / std::max(p.high - p.low, 1e-300);
    // at the end of its interval it was stopped, or is where it does nothing
    const bool ends = p.value <= p.low || p.value >= p.high;
    const double counts = ends ? 0.0 : sure;
    if (counts > most) most = counts, best = &entry;
  }
  return best;
}

/// Periods in a turn; nothing: it does not repeat.
std::optional<double> order_of(const Finding& f) {
  for (const auto& [name, p] : f.parameters) {
    const EffectParameter* known = find_parameter(f.effect, name);
    if (known != nullptr && known->role == Role::order) return p.value;
  }
  return std::nullopt;
}

std::string size_of(const Finding& f) {
  std::string text;
  if (const auto order = order_of(f)) text = fmt::format(", {:.0f} periods a turn", *order);
  const auto* size = telling(f);
  if (size == nullptr || size->second.low == size->second.high) return text;
  const VerdictParameter& p = size->second;
  return text + fmt::format(", {} {:.3g}{} ({:.3g} to {:.3g})", size->first, p.value,
                            p.unit == "-" ? "" : " " + p.unit, p.low, p.high);
}

/// Many places by their number and ends.
std::string in_short(const std::vector<std::string>& where) {
  constexpr std::size_t kListed = 4;
  if (where.size() <= kListed) return places(where);
  return fmt::format("{} places, {} to {}", where.size(), where.front(), where.back());
}

std::string finding_in_words(const Finding& f) {
  const bool set = f.status == VerdictStatus::one_of;
  std::string text = any_of(set ? f.one_of : std::vector<std::string>{f.effect});
  text += " at " + in_short(f.where);
  const std::string size = size_of(f);
  text += set && !size.empty() ? " (if it is " + name_of(f.effect) + size + ")" : size;
  switch (f.status) {
    case VerdictStatus::confirmed:
      return text + ", confirmed";
    case VerdictStatus::one_of:
      return text + ", which of them these data cannot tell: their order says nothing";
    case VerdictStatus::unfinished:
      return text + ", accepted so far";
    default:
      break;
  }
  const std::string why = reserve(f);
  return text + ", not confirmed" + (why.empty() ? "" : ": " + why);
}

std::string what(const Verdict& v) {
  if (v.status == VerdictStatus::refused) return v.answer;
  std::string text;
  if (v.unfinished) {
    text = fmt::format(
        "This answer is not finished: the run was ended after {:.0f} s, while it asked: {} ",
        v.unfinished->seconds, v.unfinished->asking);
  }
  if (v.findings.empty()) {
    if (v.unfinished) return text + "Until then no name had been accepted.";
    if (v.status == VerdictStatus::absent)
      return text +
             "Nothing is missing: what the model gets wrong is noise, or within what a nominal "
             "model may be wrong by.";
    return text + "Something is missing, and no name of the library passes every test.";
  }
  text += "Missing: ";
  for (std::size_t i = 0; i < std::min(kTold, v.findings.size()); ++i)
    text += (i == 0 ? "" : "; ") + finding_in_words(v.findings[i]);
  if (v.findings.size() > kTold) text += fmt::format("; and {} more", v.findings.size() - kTold);
  return text + ".";
}

std::string unnamed(const Verdict& v) {
  if (!v.unexplained) return "";
  const Unexplained& u = *v.unexplained;
  return fmt::format(" Something without a name stays at {}{}.", u.where,
                     u.regime.empty() ? "" : " (" + u.regime + ")");
}

/// Sizes that do not hold for all recordings.
std::string apart(const Verdict& v) {
  std::string text;
  for (const std::string& note : v.disagreements) text += " But " + note + ".";
  return text;
}

std::string better(const Verdict& v) {
  if (v.unfinished && !v.findings.empty()) {
    return fmt::format(
        " On parts left out of the fits they remove {:.0f} % of the error; nothing was scored on "
        "held-out recordings yet.",
        100 * v.unfinished->removed);
  }
  if (!v.outlook) return "";
  const Outlook& o = *v.outlook;
  const bool effort = !o.horizon.runs_ahead();
  std::string text =
      fmt::format(" On data that were not fitted the error {} {} from {:.3g} to {:.3g} {}",
                  effort ? "of the effort" : o.horizon.text() + " s ahead",
                  o.score.patched < o.score.nominal ? "falls" : "goes", o.score.nominal,
                  o.score.patched, o.unit);
  if (std::isfinite(o.score.baseline)) {
    text += fmt::format(" ({}: {:.3g}; noise {:.2g})",
                        effort ? "a constant" : "joints that go on as they went", o.score.baseline,
                        o.score.noise);
  }
  if (v.status == VerdictStatus::absent) return text + ".";
  return text + ". Grade: " + in_words(o) + ".";
}

/// What a further recording would decide.
std::string next(const Verdict& v) {
  if (v.next_experiment) {
    return fmt::format(" Record next: {}; it tells {} apart.", v.next_experiment->what,
                       any_of(v.next_experiment->separates));
  }
  if (v.unfinished) return " Let it run to its end before recording anything more.";
  if (v.status == VerdictStatus::absent) return "";
  if (v.heldout_last_part)
    return " Record next: the same motions under a second condition (half the gain, a payload, a "
           "tilted base), so that a whole recording can judge.";
  if (v.unexplained)
    return fmt::format(
        " Record next: {} alone, slow and fast, in the motions where the error "
        "shows, with its current or duty.",
        v.unexplained->where);
  return " No further recording is asked for.";
}

}  // namespace

std::string places(const std::vector<std::string>& where) {
  if (where.empty()) return "the whole robot";
  std::string text = where.front();
  for (std::size_t i = 1; i < where.size(); ++i) text += ", " + where[i];
  return text;
}

std::string sentence(const Finding& f) {
  std::string text = f.effect;
  if (f.status == VerdictStatus::one_of) {
    text = "one of {";
    for (std::size_t i = 0; i < f.one_of.size(); ++i) text += (i == 0 ? "" : ", ") + f.one_of[i];
    text += "}";
  }
  text += " at " + places(f.where);
  if (const auto order = order_of(f)) {
    text += fmt::format(" (order {:.0f})", *order);
  } else if (const auto* size = telling(f);
             size != nullptr && f.status == VerdictStatus::confirmed) {
    text += fmt::format(" ({} {:.3g} {})", size->first, size->second.value, size->second.unit);
  }
  if (const std::string why = reserve(f); !why.empty()) text += " (not confirmed: " + why + ")";
  return text;
}

std::string plain_words(const Verdict& v) {
  if (v.status == VerdictStatus::refused) return v.answer + " Nothing was fitted.";
  return what(v) + unnamed(v) + apart(v) + better(v) + next(v);
}

}  // namespace sanso::diagnose
