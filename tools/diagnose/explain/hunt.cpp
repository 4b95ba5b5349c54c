// One round of the hunt tries, in every shot under way, all changes of what it is taken to have
// lost; the one with the largest gain is made if it pays:
//
//   gain = r'Mr before - r'Mr after - (price after - price before)
//
// Changes of different shots do not meet, so that one simulation tries one change of each.
#include "tools/diagnose/explain/hunt.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

using Eigen::VectorXd;

/// The same comparison in noise levels (or trust floors): the search's own levels grew with what is
/// to be found here.
Problem in_noise_levels(const Problem& problem) {
  return {problem.comparison, floors(*problem), problem.correction};
}

SimParams params_of(const Problem& problem, const Library& library, const Model& model) {
  SimParams params = problem->sources.front().nominal;
  library.apply(model, params);
  return params;
}

Price price_of(const Comparison& comparison, const Commands& commands,
               const std::vector<std::size_t>& joints) {
  const double level = comparison.settings.decisions.family_wise;
  const double tried =
      (1.0 + commands.count(joints)) * static_cast<double>(comparison.settings.chance.loss_runs);
  return {2.0 * std::log(tried / level), 2.0 * std::log(2.0 / level)};
}

/// Some joint's position was read in this row.
bool was_read(const Drive& drive, std::size_t row) {
  return std::any_of(drive.joints.begin(), drive.joints.end(),
                     [row](const JointData& j) { return std::isfinite(j.q[row]); });
}

}  // namespace

double Price::of(const std::vector<LostCommand>& lost) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < lost.size(); ++i) {
    const bool goes_on = i > 0 && lost[i].row == lost[i - 1].row + 1;
    sum += goes_on ? further : first;
  }
  return sum;
}

Hunt::Hunt(const Surroundings& around, const Model& model, const std::vector<std::size_t>& joints)
    : library_(*around.library),
      model_(model),
      problem_(in_noise_levels(around.problem)),
      starts_(problem_, library_, model_),
      commands_(problem_.comparison, params_of(problem_, library_, model_)),
      price_(price_of(*problem_, commands_, joints)),
      state_{{}, prediction_error(problem_, library_, model_)},
      first_(state_.r) {}

/// Energy of a joint's error in a shot, starts taken out, and what noise alone makes of it.
ShotEnergy Hunt::energy_in(const VectorXd& projected, const Shot& shot, std::size_t joint) const {
  ShotEnergy out;
  for (std::size_t c = 0; c < problem_->channels.size(); ++c) {
    const Observed& channel = problem_->channels[c];
    if (channel.joint != joint) continue;
    out.all += rows_of(projected, shot, c).squaredNorm();
    out.noise += static_cast<double>(shot.rows) * std::pow(channel.noise / channel.floor, 2.0);
  }
  return out;
}

/// Shots in which the joint's error is more than noise, worst first.
std::vector<std::size_t> Hunt::outstanding(std::size_t joint) const {
  const VectorXd projected = starts_.project(state_.r);
  std::vector<std::pair<double, std::size_t>> excess;
  for (std::size_t s = 0; s < problem_->shots.size(); ++s) {
    const ShotEnergy energy = energy_in(projected, problem_->shots[s], joint);
    if (chi_square_tail(energy.all, std::max(energy.noise, 3.0)) <
        problem_->settings.decisions.family_wise)
      excess.emplace_back(energy.all, s);
  }
  std::stable_sort(excess.begin(), excess.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::size_t> out;
  out.reserve(excess.size());
  for (const auto& e : excess) out.push_back(e.second);
  return out;
}

double Hunt::beyond_noise(std::size_t joint, const std::vector<std::size_t>& shots) const {
  const VectorXd projected = starts_.project(state_.r);
  double sum = 0.0;
  for (const std::size_t s : shots) {
    const ShotEnergy energy = energy_in(projected, problem_->shots[s], joint);
    sum += std::max(0.0, energy.all - energy.noise);
  }
  return sum;
}

std::vector<LostCommand> Hunt::lost_in(const std::vector<LostCommand>& lost, const Shot& shot,
                                       std::size_t joint) const {
  return between(lost, shot.source, joint, commands_.first_row(shot, joint), shot.window.last);
}

/// Every row and run whose loss would change what a shot receives, or a loss that is taken back.
std::vector<Change> Hunt::all_changes(const Shot& shot, std::size_t joint) const {
  std::vector<Change> out;
  for (std::size_t row = commands_.first_row(shot, joint); row < shot.window.last; ++row) {
    if (!commands_.changes(shot.source, joint, row) &&
        !holds(state_.lost, {shot.source, joint, row - 1}))
      continue;
    for (int k = 0; k < problem_->settings.chance.loss_runs; ++k) {
      const std::size_t run = std::size_t{1} << k;
      if (row + run <= shot.window.last) out.push_back({row, run});
    }
  }
  return out;
}

/// What was second best to the change just made, and what lets its run grow.
std::vector<Change> Hunt::promising_after(const std::vector<Change>& sorted, const Shot& shot,
                                          std::size_t joint) const {
  const std::size_t kept =
      std::min(sorted.size(), static_cast<std::size_t>(problem_->settings.chance.promising));
  std::vector<Change> out(sorted.begin() + 1, sorted.begin() + static_cast<std::ptrdiff_t>(kept));
  const std::size_t row = sorted.front().row, end = row + sorted.front().run;
  if (row > commands_.first_row(shot, joint)) out.push_back({row - 1, 1});
  if (end < shot.window.last) out.push_back({end, 1});
  return out;
}

/// Gains of changes, tried one at a time in every shot: pass p tries the p-th of each.
void Hunt::try_out(std::size_t joint, const std::vector<Hunted>& hunted,
                   std::vector<std::vector<Change>>& of) const {
  std::size_t passes = 0;
  for (const std::vector<Change>& one : of) passes = std::max(passes, one.size());
  const VectorXd before = starts_.energy_by_shot(state_.r);
  parallel_for(passes, [&](std::size_t pass) {
    std::vector<LostCommand> lost = state_.lost;
    std::vector<char> wanted(problem_->shots.size(), 0);
    for (std::size_t i = 0; i < of.size(); ++i) {
      if (pass >= of[i].size()) continue;
      put(lost, problem_->shots[hunted[i].shot], joint, of[i][pass]);
      wanted[hunted[i].shot] = 1;
    }
    const VectorXd r =
        prediction_error_with_lost(problem_, library_, model_, state_.r, lost, wanted, {joint});
    const VectorXd after = starts_.energy_by_shot(r, wanted),
                   made = starts_.energy_by_shot(r - state_.r, wanted);
    for (std::size_t i = 0; i < of.size(); ++i) {
      if (pass >= of[i].size()) continue;
      Change& c = of[i][pass];
      const Shot& shot = problem_->shots[hunted[i].shot];
      const std::size_t s = hunted[i].shot;
      c.energy = before[s] - after[s];
      const std::vector<LostCommand> had = lost_in(state_.lost, shot, joint);
      std::vector<LostCommand> has = had;
      put(has, shot, joint, c);
      c.gain = c.energy + price_.of(had) - price_.of(has);
      c.made = made[s];
    }
  });
}

/// e = r'Mr is a parabola of the share that is lost, and -1 is the command that goes too far:
///
///   e(0) - e(-1) = -(e(0) - e(1)) - 2 made
void Hunt::note_mirrored(const std::vector<Change>& tried) {
  double loss = 0.0, beyond = 0.0;
  for (const Change& c : tried) {
    loss = std::max(loss, c.gain);
    beyond = std::max(beyond, c.gain - 2.0 * (c.energy + c.made));
  }
  mirrored_.losses += loss, mirrored_.beyond += beyond;
}

/// The best change of every shot under way, where it pays. Returns the shots that stay under way;
/// `moved`: those whose losses are others now.
std::vector<Hunted> Hunt::round(std::size_t joint, const std::vector<Hunted>& hunted,
                                std::vector<char>& moved) {
  std::vector<std::vector<Change>> of;
  of.reserve(hunted.size());
  for (const Hunted& h : hunted) {
    of.push_back(h.promising.empty() ? all_changes(problem_->shots[h.shot], joint) : h.promising);
  }
  try_out(joint, hunted, of);
  std::vector<Hunted> again;
  // later, what was lost elsewhere has moved what else is fitted
  const bool untouched = state_.lost.empty();
  for (std::size_t i = 0; i < hunted.size(); ++i) {
    std::stable_sort(of[i].begin(), of[i].end(),
                     [](const Change& a, const Change& b) { return a.gain > b.gain; });
    const Shot& shot = problem_->shots[hunted[i].shot];
    const bool pays = !of[i].empty() && of[i].front().gain > 0.0;
    if (untouched) note_mirrored(of[i]);
    if (!pays && hunted[i].promising.empty()) continue;  // nothing of all there is pays
    again.push_back({hunted[i].shot});
    if (!pays) continue;
    put(state_.lost, shot, joint, of[i].front());
    best_gain_ = std::max(best_gain_, of[i].front().gain);
    moved[hunted[i].shot] = 1;
    again.back().promising = promising_after(of[i], shot, joint);
  }
  state_.r =
      prediction_error_with_lost(problem_, library_, model_, state_.r, state_.lost, moved, {joint});
  return again;
}

/// Takes the losses of these shots, the best change at a time, as long as they pay. Returns how
/// many shots had one.
std::size_t Hunt::take(std::size_t joint, const std::vector<std::size_t>& shots) {
  std::vector<Hunted> hunted;
  hunted.reserve(shots.size());
  for (const std::size_t s : shots) hunted.push_back({s});
  std::set<std::size_t> with;
  for (int n = 0; n < problem_->settings.chance.loss_changes && !hunted.empty(); ++n) {
    std::vector<char> moved(problem_->shots.size(), 0);
    hunted = round(joint, hunted, moved);
    for (std::size_t s = 0; s < moved.size(); ++s) {
      if (moved[s] != 0) with.insert(s);
    }
  }
  return with.size();
}

bool Hunt::lost_some(std::size_t joint) {
  std::vector<std::size_t> worst = outstanding(joint);
  if (worst.empty()) return false;
  worst.resize(
      std::min(worst.size(), static_cast<std::size_t>(problem_->settings.chance.worst_shots)));
  const Repaired before = state_;
  const auto mirrored_before = mirrored_;
  const double stood = beyond_noise(joint, worst);
  take(joint, worst);
  if (2.0 * beyond_noise(joint, worst) <= stood) return true;
  state_ = before, mirrored_ = mirrored_before;
  return false;
}

/// Commands of the cycles without a reading, or of those `shift` rows later.
std::vector<LostCommand> Hunt::unread(const std::vector<std::size_t>& joints, int shift) const {
  std::vector<LostCommand> out;
  for (std::size_t s = 0; s < problem_->sources.size(); ++s) {
    const Drive& drive = problem_->sources[s].drive;
    for (const std::size_t j : joints) {
      bool before = false;  // after a loss the same command once more is a new one
      for (std::size_t row = 1; row < drive.rows(); ++row) {
        const std::size_t sent = row - static_cast<std::size_t>(shift);
        const bool lost = sent > 0 && sent < drive.rows() && !was_read(drive, sent);
        before = lost && (before || commands_.changes(s, j, row));
        if (before) out.push_back({s, j, row});
      }
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

bool Hunt::lost_with_readings(const std::vector<std::size_t>& joints) {
  const double before = starts_.energy_by_shot(state_.r).sum();
  Repaired best;
  double least = before - price_.first;
  for (const int shift : {0, -1, 1}) {
    Repaired trial{unread(joints, shift), {}};
    if (trial.lost.empty()) continue;
    trial.r =
        prediction_error_with_lost(problem_, library_, model_, state_.r, trial.lost, {}, joints);
    const double energy = starts_.energy_by_shot(trial.r).sum();
    if (energy < least) least = energy, best = std::move(trial);
  }
  if (best.lost.empty()) return false;
  double stood = 0.0, left = 0.0;
  for (const std::size_t joint : joints) {
    const std::vector<std::size_t> shots = outstanding(joint);
    stood += beyond_noise(joint, shots);
    std::swap(state_, best);
    left += beyond_noise(joint, shots);
    std::swap(state_, best);
  }
  if (2.0 * left > stood) return false;
  Unread found;
  double runs = 0.0;
  for (const Source& source : problem_->sources) {
    for (std::size_t row = 1; row < source.drive.rows(); ++row) {
      const bool lost = !was_read(source.drive, row);
      found.lost += lost ? 1 : 0, ++found.cycles;
      runs += lost && was_read(source.drive, row - 1) ? 1.0 : 0.0;
    }
  }
  found.runs = found.lost / std::max(1.0, runs);
  found.made = starts_.energy_by_shot(best.r - state_.r).sum();
  // e(theta) is a parabola through both, of the curvature of what they change
  found.theta = 0.5 * (1.0 + (before - least) / found.made);
  with_readings_ = found;
  state_ = std::move(best);
  best_gain_ = std::max(best_gain_, before - least);
  return true;
}

void Hunt::take_all(std::size_t joint) { take(joint, outstanding(joint)); }

void Hunt::forget_nuisances() {
  model_.nuisance.assign(library_.nuisances.size(), 0.0);
  state_.r = prediction_error_with_lost(problem_, library_, model_, state_.r, state_.lost, {}, {});
}

void Hunt::refit() {
  const Problem known = with_lost(problem_, state_.lost);
  Surroundings around = make_surroundings(known, library_, model_);
  around.set_shot_scale(around.starts.energy_by_shot(prediction_error(known, library_, model_)));
  model_ = fit(around, model_, around.settings().fitting.steps_anew).model;
  starts_ = StartElimination(problem_, library_, model_);
  state_.r = prediction_error(known, library_, model_);
}

/// `changes`: by shot of the problem.
std::vector<std::vector<Change>> Hunt::tried_alone(std::size_t joint,
                                                   std::vector<std::vector<Change>> changes) const {
  std::vector<Hunted> hunted;
  hunted.reserve(changes.size());
  for (std::size_t s = 0; s < changes.size(); ++s) hunted.push_back({s});
  try_out(joint, hunted, changes);
  return changes;
}

std::vector<std::vector<Change>> Hunt::taken_back(std::size_t joint) const {
  std::vector<std::vector<Change>> back(problem_->shots.size());
  for (std::size_t s = 0; s < back.size(); ++s) {
    for (const LostCommand& l : lost_in(state_.lost, problem_->shots[s], joint))
      back[s].push_back({l.row, 1});
  }
  return tried_alone(joint, std::move(back));
}

std::vector<std::vector<Change>> Hunt::each_alone(std::size_t joint) const {
  std::vector<std::vector<Change>> all(problem_->shots.size());
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Shot& shot = problem_->shots[s];
    for (std::size_t row = commands_.first_row(shot, joint); row < shot.window.last; ++row)
      if (commands_.changes(shot.source, joint, row)) all[s].push_back({row, 1});
  }
  return tried_alone(joint, std::move(all));
}

}  // namespace sanso::diagnose
