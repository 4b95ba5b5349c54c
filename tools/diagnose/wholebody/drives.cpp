// Drives and links of a robot that stands on soles whose forces nobody measured: motion given,
// what torque is missing?
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "tools/diagnose/wholebody/drive_choice.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

/// What these balances were shown to place right; the others stand in for them only.
std::vector<std::string> placed() {
  std::vector<const Effect*> effects;
  for (const Effect& effect : library()) {
    if (effect.drive && effect.drive->placed) effects.push_back(&effect);
  }
  std::sort(effects.begin(), effects.end(),
            [](const Effect* a, const Effect* b) { return a->drive->figure < b->drive->figure; });
  std::vector<std::string> out;
  for (const Effect* effect : effects) out.emplace_back(effect->id);
  return out;
}

Finding finding_of(const Asking& asking, const JudgedDriveTerm& j) {
  Finding f;
  f.effect = j.term.effect, f.family = j.term.family, f.where = j.term.where;
  f.regime = "stance";
  for (std::size_t i = 0; i < j.parameters.size(); ++i)
    f.parameters[j.term.parameters[i]] = j.parameters[i];
  f.heldout_gain = j.share, f.heldout_gain_low = j.share_low;
  f.p_family = asking.chance().family_wise(j.size / std::max(j.sigma, 1e-300));
  f.one_of = {f.effect};
  f.one_of.insert(f.one_of.end(), j.equally_good.begin(), j.equally_good.end());
  f.status = status_of(f);
  if (!j.other_places.empty() && f.status == VerdictStatus::confirmed)
    f.status = VerdictStatus::one_of;
  return f;
}

std::string text_of(const JudgedDriveTerm& j) {
  std::string out = in_words(j.term) + ":";
  for (std::size_t i = 0; i < j.parameters.size(); ++i) {
    const VerdictParameter& p = j.parameters[i];
    out += fmt::format(" {} {:.4g} [{:.4g}, {:.4g}] {}", j.term.parameters[i], p.value, p.low,
                       p.high, p.unit);
  }
  return out;
}

bool named(const Asking& asking, const JudgedDriveTerm& j) {
  const Effect& effect = *find_effect(j.term.effect);
  return effect.drive && effect.drive->placed &&
         j.size > j.term.tolerance + asking.chance().deviations() * j.sigma;
}

/// `alone`: nothing else is in the balance, and it is one.
void judge(const Asking& asking, const JudgedDriveTerm& j, bool alone, WholeAnswers& answers,
           Patch& patch) {
  answers.log.push_back(text_of(j));
  if (!named(asking, j)) {
    answers.notes.push_back(text_of(j) + ": described, not named");
    return;
  }
  for (const std::string& place : j.other_places)
    answers.notes.push_back(in_words(j.term) + ": as well " + place);
  answers.findings.push_back(finding_of(asking, j));
  if (!alone) answers.findings.back().status = VerdictStatus::present_unnamed;
  if (!alone) return;
  EffectEntry entry{j.term.effect, j.term.where, {}, 0};
  for (std::size_t i = 0; i < j.parameters.size(); ++i)
    entry.parameters[j.term.parameters[i]] = j.parameters[i].value;
  patch.entries.push_back(std::move(entry));
}

}  // namespace

void ask_drives(const Asking& asking, WholeAnswers& answers, Patch& patch) {
  const DriveRows rows = drive_rows(asking);
  if (!rows.why_not.empty()) {
    for (const std::string& effect : placed()) answers.cannot(effect, rows.why_not);
    return;
  }
  answers.asked += placed().size();
  const char* no_centre = "torques of legs on unmeasured soles were not shown to place a mass";
  answers.cannot(WholeFigure::centre, no_centre);
  const DriveChoice choice = choose_drive_terms(asking, rows);
  answers.log.insert(answers.log.end(), choice.log.begin(), choice.log.end());
  answers.scores["stance"] = {choice.before, choice.after, 1.0,
                              std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::quiet_NaN()};
  const bool alone =
      choice.adequate && std::all_of(choice.terms.begin(), choice.terms.end(),
                                     [&](const auto& j) { return named(asking, j); });
  if (!alone)
    answers.notes.push_back(
        "drives: more is missing than these balances can name, so no size among them is sure");
  for (const JudgedDriveTerm& j : choice.terms) judge(asking, j, alone, answers, patch);
}

}  // namespace sanso::diagnose
