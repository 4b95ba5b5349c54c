// Drives and links of a robot that stands on soles whose forces nobody measured: motion given,
// what torque is missing?
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "tools/diagnose/wholebody/drive_balance.h"
#include "tools/diagnose/wholebody/names_apart.h"
#include "tools/diagnose/wholebody/questions.h"
#include "tools/diagnose/wholebody/stance_left.h"

namespace sanso::diagnose {
namespace {

/// What these balances were shown to place right; the others stand in for them only.
bool placed(const Effect& effect) {
  return (effect.drive && effect.drive->placed) || effect.whole == WholeFigure::mass_share ||
         effect.whole == WholeFigure::centre || effect.whole == WholeFigure::payload ||
         effect.whole == WholeFigure::force_scale;
}

std::vector<std::string> all_placed() {
  std::vector<std::string> out;
  for (const Effect& effect : library()) {
    if (placed(effect)) out.emplace_back(effect.id);
  }
  return out;
}

Finding finding_of(const Asking& asking, const JudgedDriveTerm& j) {
  Finding f;
  f.effect = j.term.effect, f.family = to_string(j.term.family), f.where = j.term.where;
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
  return placed(*find_effect(j.term.effect)) && surely_there(asking, j);
}

/// `alone`: nothing else is in the balance, and it is one. `worth`: it may be named beside what has
/// no name.
Answered judge(const Asking& asking, const JudgedDriveTerm& j, bool alone, bool worth) {
  Answered out;
  out.answers.log.push_back(text_of(j));
  if (!named(asking, j) || !worth) {
    out.answers.notes.push_back(text_of(j) + ": described, not named");
    return out;
  }
  for (const std::string& place : j.other_places)
    out.answers.notes.push_back(in_words(j.term) + ": as well " + place);
  out.answers.findings.push_back(finding_of(asking, j));
  if (!alone) out.answers.findings.back().status = VerdictStatus::present_unnamed;
  if (!alone) return out;
  EffectEntry entry{j.term.effect, j.term.where, {}, 0};
  for (std::size_t i = 0; i < j.parameters.size(); ++i)
    entry.parameters[j.term.parameters[i]] = j.parameters[i].value;
  out.patch.entries.push_back(std::move(entry));
  return out;
}

/// Somebody pushed: a force that comes, goes, and is nowhere else in that recording. `alone`:
/// nothing without a name is left that might read as one.
WholeAnswers judge_pushes(const Asking& asking, const std::vector<Push>& pushes, bool alone) {
  WholeAnswers answers;
  if (pushes.empty()) return answers;
  const Push& p = pushes.front();
  const Effect& effect = effect_of(WholeFigure::push);
  Finding f;
  f.effect = effect.id, f.family = to_string(effect.family), f.where = {asking.body.root};
  f.regime = effect.regimes.front();
  const double off = p.force.norm();  // where somebody pushes is not known
  const WholeRecording& r = asking.recordings[p.recording];
  const double values[] = {p.force[0], p.force[1], p.force[2], p.from - r.t.front(), p.to - p.from};
  for (std::size_t i = 0; i < effect.parameters.size() && i < std::size(values); ++i) {
    const double wide = i < 3 ? off : asking.stance.window;
    f.parameters[std::string(effect.parameters[i].name)] = {
        values[i], values[i] - wide, values[i] + wide, std::string(effect.parameters[i].unit),
        false};
  }
  f.p_family = asking.chance().family_wise(p.beyond);
  f.one_of = {f.effect};
  f.status = alone ? status_of(f) : VerdictStatus::present_unnamed;
  answers.findings.push_back(f);
  for (const Push& each : pushes)
    answers.notes.push_back(fmt::format(
        "{}: pushed from {:.2f} s to {:.2f} s by [{:.2f}, {:.2f}, {:.2f}] N, {:.1f} times what is "
        "usual in it",
        asking.recordings[each.recording].name, each.from, each.to, each.force[0], each.force[1],
        each.force[2], each.beyond));
  return answers;
}

/// Where what has no name would be a torque, or a force on the base; strongest first.
std::vector<LocationCell> locations_of(const Asking& asking, const StanceLeft& left) {
  std::vector<LocationCell> out;
  const double all = std::accumulate(left.at.begin(), left.at.end(), 0.0);
  for (std::size_t i = 0; i < left.at.size(); ++i) {
    LocationCell cell;
    cell.where = i == 0 ? asking.body.root : asking.body.model.tree.joints[i - 1].name;
    cell.regime = "stance", cell.share = left.at[i] / std::max(all, 1e-300);
    out.push_back(cell);
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.share > b.share; });
  return out;
}

bool any_moves(const Asking& asking, const DriveRows& rows) {
  for (Eigen::Index j = 0; j < rows.columns.joints; ++j)
    if (moves(asking, rows, j)) return true;
  return false;
}

/// Whether a heavier link is told from sensors that read too much.
bool weighed_by(const DriveChoice& choice) {
  const std::string scale = name_of(WholeFigure::force_scale);
  return std::any_of(choice.terms.begin(), choice.terms.end(), [&](const auto& j) {
    return j.term.effect == scale || find_effect(j.term.effect)->family == Family::mass;
  });
}

}  // namespace

Answered ask_drives(const Asking& asking) {
  Answered out;
  auto [rows, choice] = balance_drives(asking);
  if (!rows.why_not.empty()) {
    for (const std::string& effect : all_placed()) out.answers.cannot(effect, rows.why_not);
    return out;
  }
  out.answers.asked += all_placed().size();
  if (!any_moves(asking, rows)) {
    for (const JointFigure figure : {JointFigure::speed, JointFigure::dry, JointFigure::load})
      out.answers.cannot(std::string(effect_of(figure)->id),
                         "no joint moves for a second: what holds it may be "
                         "anything");
  }
  StanceLeft left = stance_left(rows, choice.figures, asking.stance.pushed);
  const std::vector<Push> pushes = left.pushes;
  if (!pushes.empty()) {  // whoever pushes is no figure of the robot
    rows = without(rows, pushes);
    choice = choose_drive_terms(asking, rows);
    left = stance_left(rows, choice.figures, asking.stance.pushed);
  }
  out.answers.log.insert(out.answers.log.end(), choice.log.begin(), choice.log.end());
  out.answers.scores[kStanceBalance] = {choice.before, choice.after, choice.least,
                                        std::numeric_limits<double>::quiet_NaN(),
                                        std::numeric_limits<double>::quiet_NaN()};
  const bool alone =
      choice.adequate && std::all_of(choice.terms.begin(), choice.terms.end(),
                                     [&](const auto& j) { return named(asking, j); });
  // names that leave most of it are what something else reads like
  const bool worth = alone || choice.eased >= asking.stance.eased;
  for (const JudgedDriveTerm& j : choice.terms) out.take(judge(asking, j, alone, worth));
  for (const JudgedDriveTerm& j : choice.spare)
    out.answers.notes.push_back(text_of(j) + ": described, not named");
  out.answers.take(judge_pushes(asking, pushes, alone));
  if (worth) out.apart = names_apart(asking, rows, choice);
  out.shown = stance_shown(rows, choice.named);
  out.weighed = alone && weighed_by(choice);
  if (alone) return out;
  out.answers.notes.push_back(
      "drives: more is missing than these balances can name, so no size among them is sure");
  out.answers.unnamed = true;
  out.answers.locations = locations_of(asking, left);
  return out;
}

}  // namespace sanso::diagnose
