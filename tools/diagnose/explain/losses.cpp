#include "tools/diagnose/explain/losses.h"

#include <algorithm>
#include <set>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The same comparison in noise levels (or trust floors): the search's own levels grew with what is
/// to be found here.
Problem in_noise_levels(Problem problem) {
  for (Observed& channel : problem.channels) channel.sigma = channel.floor;
  return problem;
}

/// A change of what one shot is taken to have lost.
struct Change {
  // run 1: the row is lost, or no longer; longer: all of these are lost
  std::size_t row = 0, run = 0;
  double gain = -INFINITY;  // energy that it takes from the shot, less the price
  double energy = 0.0;      // the same without the price
  double made = 0.0;        // energy of the change it makes
};

/// A shot under way, and the changes to try next; none: all that there are.
struct Hunted {
  std::size_t shot = 0;
  std::vector<Change> promising = {};
};

/// Commands whose loss would change the motion alike much.
struct Showing {
  int commands = 0, lost = 0;
  /// Of the share lost, 95 %, when as many as `together` events are one.
  Interval interval(double together) const {
    return wilson_interval(static_cast<int>(std::lround(lost / together)),
                           static_cast<int>(std::lround(std::max(commands, lost) / together)));
  }
};

class Hunt {
 public:
  Hunt(const Surroundings& around, const FitResult& final)
      : library_(*around.library),
        model_(final.model),
        problem_(in_noise_levels(*around.problem)),
        starts_(problem_, library_, model_),
        r_(prediction_error(problem_, library_, model_)),
        first_(r_),
        params_(problem_.sources.front().nominal) {
    library_.apply(model_, params_);
  }

  LossScore all() {
    const std::vector<int> joints = joints_that_may_lose();
    count_commands(joints);
    std::vector<int> losing;
    for (const int joint : joints) {
      if (lost_some(joint)) losing.push_back(joint);
    }
    if (losing.empty()) return {};
    // what losses do on average was taken for a lag within tolerance: from the model's own figures
    // anew
    model_.nuisance.assign(library_.nuisances.size(), 0.0);
    r_ = prediction_error_with_lost(problem_, library_, model_, r_, lost_, {}, {});
    for (const int joint : losing) take(joint, outstanding(joint));
    for (int pass = 0; pass < chance().loss_refits; ++pass) {
      refit();
      const std::vector<LostCommand> before = lost_;
      for (const int joint : losing) take(joint, outstanding(joint));
      if (lost_.size() == before.size()) break;
    }
    return conclude(losing);
  }

 private:
  const ChanceSettings& chance() const { return problem_.settings.chance; }
  const Candidate& candidate(int i) const {
    return library_.candidates[static_cast<std::size_t>(i)];
  }

  /// Whether a candidate makes commands be lost, and nothing else.
  bool loses(int i) const {
    if (!candidate(i).random || model_.has(i)) return false;
    SimParams with = params_;
    candidate(i).apply(with, candidate(i).probes.front());
    return std::all_of(candidate(i).joints.begin(), candidate(i).joints.end(), [&](int j) {
      return with.joints[static_cast<std::size_t>(j)].loss >
             params_.joints[static_cast<std::size_t>(j)].loss;
    });
  }

  std::vector<int> joints_that_may_lose() const {
    std::vector<int> out;
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      const Candidate& c = library_.candidates[i];
      if (c.joints.size() == 1 && loses(static_cast<int>(i))) out.push_back(c.joints.front());
    }
    return out;
  }

  /// Rows whose command acts in a shot: from those still under way at its start.
  std::size_t first_row(const Shot& shot, int joint) const {
    const std::vector<double>& t = problem_.sources[static_cast<std::size_t>(shot.source)].drive.t;
    const JointParams& p = params_.joints[static_cast<std::size_t>(joint)];
    const double early =
        p.nominal.command_delay_s + p.command_delay + p.nominal.sensor_delay_s + p.sensor_delay;
    std::size_t row = shot.window.first;
    while (row > 1 && t[row] > t[shot.window.first] - early) --row;
    return std::max<std::size_t>(row, 1);
  }

  const std::vector<double>& command(int source, int joint) const {
    return problem_.sources[static_cast<std::size_t>(source)]
        .drive.joints[static_cast<std::size_t>(joint)]
        .command;
  }

  /// What the servo does not notice when it is lost is no event.
  bool changes(int source, int joint, std::size_t row) const {
    const std::vector<double>& u = command(source, joint);
    return row < u.size() && std::isfinite(u[row]) && std::isfinite(u[row - 1]) &&
           u[row] != u[row - 1];
  }

  bool is_lost(const LostCommand& command) const {
    return std::binary_search(lost_.begin(), lost_.end(), command);
  }

  void count_commands(const std::vector<int>& joints) {
    double tried = 1.0;
    for (const int joint : joints) {
      for (const Shot& shot : problem_.shots) {
        for (std::size_t row = first_row(shot, joint); row < shot.window.last; ++row)
          tried += changes(shot.source, joint, row) ? 1.0 : 0.0;
      }
    }
    tried_ = tried * static_cast<double>(chance().loss_runs);
    least_gain_ = 2.0 * std::log(tried_ / problem_.settings.decisions.family_wise);
  }

  /// Shots in which the joint's error is more than noise, worst first.
  std::vector<std::size_t> outstanding(int joint) const {
    const VectorXd projected = starts_.project(r_);
    std::vector<std::pair<double, std::size_t>> excess;
    for (std::size_t s = 0; s < problem_.shots.size(); ++s) {
      const Shot& shot = problem_.shots[s];
      double energy = 0.0, freedom = 0.0;
      for (std::size_t c = 0; c < problem_.channels.size(); ++c) {
        const Observed& channel = problem_.channels[c];
        if (channel.joint != joint) continue;
        energy += projected
                      .segment(static_cast<Index>(shot.offset + c * shot.rows),
                               static_cast<Index>(shot.rows))
                      .squaredNorm();
        freedom += static_cast<double>(shot.rows) * std::pow(channel.noise / channel.floor, 2.0);
      }
      if (chi_square_tail(energy, std::max(freedom, 3.0)) < problem_.settings.decisions.family_wise)
        excess.emplace_back(energy, s);
    }
    std::stable_sort(excess.begin(), excess.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::size_t> out;
    for (const auto& e : excess) out.push_back(e.second);
    return out;
  }

  /// Puts a change of one shot into sorted losses.
  static void put(std::vector<LostCommand>& lost, const Shot& shot, int joint,
                  const Change& change) {
    for (std::size_t k = 0; k < change.run; ++k) {
      const LostCommand one{shot.source, joint, change.row + k};
      const auto at = std::lower_bound(lost.begin(), lost.end(), one);
      const bool there = at != lost.end() && !(one < *at);
      if (there && change.run == 1) lost.erase(at);
      if (!there) lost.insert(at, one);
    }
  }

  /// The losses of one shot.
  std::vector<LostCommand> lost_in(const Shot& shot, int joint) const {
    const auto from = std::lower_bound(lost_.begin(), lost_.end(),
                                       LostCommand{shot.source, joint, first_row(shot, joint)});
    return {from,
            std::lower_bound(from, lost_.end(), LostCommand{shot.source, joint, shot.window.last})};
  }

  /// What a shot's losses have to gain: each run of them its place among all commands, each further
  /// row of a run that it goes on at this end or at the other.
  double price(const std::vector<LostCommand>& of_shot) const {
    const double further = 2.0 * std::log(2.0 / problem_.settings.decisions.family_wise);
    double sum = 0.0;
    for (std::size_t i = 0; i < of_shot.size(); ++i) {
      const bool goes_on = i > 0 && of_shot[i].row == of_shot[i - 1].row + 1;
      sum += goes_on ? further : least_gain_;
    }
    return sum;
  }

  /// Every row and run whose loss would change what a shot receives, or a loss that is taken back.
  std::vector<Change> all_changes(const Shot& shot, int joint) const {
    std::vector<Change> out;
    for (std::size_t row = first_row(shot, joint); row < shot.window.last; ++row) {
      if (!changes(shot.source, joint, row) && !is_lost({shot.source, joint, row - 1})) continue;
      for (int k = 0; k < chance().loss_runs; ++k) {
        const std::size_t run = std::size_t{1} << k;
        if (row + run <= shot.window.last) out.push_back({row, run});
      }
    }
    return out;
  }

  /// Gains of changes, tried one at a time in every shot: pass p tries the p-th of each.
  void try_out(int joint, const std::vector<Hunted>& hunted,
               std::vector<std::vector<Change>>& of) const {
    std::size_t passes = 0;
    for (const std::vector<Change>& one : of) passes = std::max(passes, one.size());
    const VectorXd before = starts_.energy_by_shot(r_);
    parallel_for(static_cast<int>(passes), [&](int p) {
      const auto pass = static_cast<std::size_t>(p);
      std::vector<LostCommand> lost = lost_;
      std::vector<char> wanted(problem_.shots.size(), 0);
      for (std::size_t i = 0; i < of.size(); ++i) {
        if (pass >= of[i].size()) continue;
        put(lost, problem_.shots[hunted[i].shot], joint, of[i][pass]);
        wanted[hunted[i].shot] = 1;
      }
      const VectorXd r =
          prediction_error_with_lost(problem_, library_, model_, r_, lost, wanted, {joint});
      const VectorXd after = starts_.energy_by_shot(r), made = starts_.energy_by_shot(r - r_);
      for (std::size_t i = 0; i < of.size(); ++i) {
        if (pass >= of[i].size()) continue;
        Change& c = of[i][pass];
        const Shot& shot = problem_.shots[hunted[i].shot];
        const auto s = static_cast<Index>(hunted[i].shot);
        c.energy = before[s] - after[s];
        const std::vector<LostCommand> had = lost_in(shot, joint);
        std::vector<LostCommand> has = had;
        put(has, shot, joint, c);
        c.gain = c.energy + price(had) - price(has);
        c.made = made[s];
      }
    });
  }

  /// Energy of what the loss of one command changes, by the square of the command's step.
  void note_responses(int joint, int source, const std::vector<Change>& tried) {
    const std::vector<double>& u = command(source, joint);
    for (const Change& c : tried) {
      if (c.run != 1 || !changes(source, joint, c.row)) continue;
      const double jump = u[c.row] - u[c.row - 1];
      response_.push_back(c.made / (jump * jump));
    }
  }

  /// Takes the losses of these shots, the best change at a time, as long as they pay. Returns how
  /// many shots had one.
  std::size_t take(int joint, const std::vector<std::size_t>& shots) {
    std::vector<Hunted> hunted;
    for (const std::size_t s : shots) hunted.push_back({s});
    std::set<std::size_t> with;
    for (int round = 0; round < chance().loss_changes && !hunted.empty(); ++round) {
      std::vector<std::vector<Change>> of;
      for (const Hunted& h : hunted)
        of.push_back(h.promising.empty() ? all_changes(problem_.shots[h.shot], joint)
                                         : h.promising);
      try_out(joint, hunted, of);
      std::vector<char> moved(problem_.shots.size(), 0);
      std::vector<Hunted> again;
      for (std::size_t i = 0; i < hunted.size(); ++i) {
        std::stable_sort(of[i].begin(), of[i].end(),
                         [](const Change& a, const Change& b) { return a.gain > b.gain; });
        const Shot& shot = problem_.shots[hunted[i].shot];
        const bool pays = !of[i].empty() && of[i].front().gain > 0.0;
        if (hunted[i].promising.empty()) note_responses(joint, shot.source, of[i]);
        if (!pays && hunted[i].promising.empty()) continue;  // nothing of all there is pays
        again.push_back({hunted[i].shot});
        if (!pays) continue;
        put(lost_, shot, joint, of[i].front());
        best_gain_ = std::max(best_gain_, of[i].front().gain);
        moved[hunted[i].shot] = 1;
        with.insert(hunted[i].shot);
        again.back().promising = promising_after(of[i], shot, joint);
      }
      r_ = prediction_error_with_lost(problem_, library_, model_, r_, lost_, moved, {joint});
      hunted = std::move(again);
    }
    return with.size();
  }

  /// What was second best to the change just made, and what lets its run grow.
  std::vector<Change> promising_after(const std::vector<Change>& sorted, const Shot& shot,
                                      int joint) const {
    std::vector<Change> out(
        sorted.begin() + 1,
        sorted.begin() + static_cast<std::ptrdiff_t>(std::min(
                             sorted.size(), static_cast<std::size_t>(chance().promising))));
    const std::size_t row = sorted.front().row, end = row + sorted.front().run;
    if (row > first_row(shot, joint)) out.push_back({row - 1, 1});
    if (end < shot.window.last) out.push_back({end, 1});
    return out;
  }

  /// Whether losses explain most of the shots that are farthest from noise.
  bool lost_some(int joint) {
    std::vector<std::size_t> worst = outstanding(joint);
    if (worst.empty()) return false;
    worst.resize(std::min(worst.size(), static_cast<std::size_t>(chance().worst_shots)));
    const std::vector<LostCommand> before = lost_;
    const VectorXd r_before = r_;
    if (2 * take(joint, worst) >= worst.size()) return true;
    lost_ = before;
    r_ = r_before;
    return false;
  }

  /// Nuisances were fitted to motions with the losses in them: once more, with the losses known.
  void refit() {
    Problem known = problem_;
    hold(known, lost_);
    Surroundings around = make_surroundings(known, library_, model_);
    around.set_shot_scale(around.starts.energy_by_shot(prediction_error(known, library_, model_)));
    model_ = fit(around, model_, 3).model;
    starts_ = StartElimination(problem_, library_, model_);
    r_ = prediction_error(known, library_, model_);
  }

  /// The smallest candidate that loses commands at all of these joints.
  int candidate_at(const std::vector<int>& losing) const {
    int best = -1;
    for (std::size_t i = 0; i < library_.candidates.size(); ++i) {
      const std::vector<int>& own = library_.candidates[i].joints;
      const bool all = std::all_of(losing.begin(), losing.end(), [&](int j) {
        return std::find(own.begin(), own.end(), j) != own.end();
      });
      if (!all || !loses(static_cast<int>(i))) continue;
      if (best < 0 || own.size() < candidate(best).joints.size()) best = static_cast<int>(i);
    }
    return best;
  }

  LossScore conclude(const std::vector<int>& losing) {
    LossScore out;
    out.candidate = candidate_at(losing);
    if (out.candidate < 0) return {};
    std::sort(lost_.begin(), lost_.end());
    out.lost = lost_;
    Showing showing, hidden;
    const double response = median(response_);
    const auto place = [&](int source, int joint, std::size_t row) -> Showing& {
      const double jump = command(source, joint)[row] - command(source, joint)[row - 1];
      return changes(source, joint, row) && response * jump * jump > least_gain_ ? showing : hidden;
    };
    for (const Shot& shot : problem_.shots) {
      for (const int joint : candidate(out.candidate).joints) {
        for (std::size_t row = first_row(shot, joint); row < shot.window.last; ++row) {
          if (changes(shot.source, joint, row)) ++place(shot.source, joint, row).commands;
        }
      }
    }
    for (const LostCommand& l : lost_) ++place(l.source, l.joint, l.row).lost;
    out.seen = showing.lost;
    out.visible = showing.commands;
    const double together = run_effect();
    const Interval interval = showing.interval(together);
    out.size = static_cast<double>(out.seen) / std::max(1, out.visible);
    out.low = interval.low;
    out.high = interval.high;
    out.blind = hidden.interval(1.0).low <= showing.interval(1.0).high;
    out.misfit = misfit(losing);
    out.p_family =
        std::min(1.0, problem_.settings.decisions.family_wise * std::exp(-0.5 * best_gain_));
    out.repaired = starts_.project(r_);
    out.energy = position_energy(starts_.project(first_)) - position_energy(out.repaired);
    Surroundings around{&problem_, &library_, starts_, {}};
    around.set_shot_scale(starts_.energy_by_shot(r_));
    out.left = position_error_level(around, r_, {});
    return out;
  }

  /// Losses come in runs: how many count as one independent event (mean square of the runs' lengths
  /// over their mean).
  double run_effect() const {
    double sum = 0.0, squares = 0.0, run = 0.0;
    for (std::size_t i = 0; i < lost_.size(); ++i) {
      const bool goes_on = i > 0 && lost_[i].source == lost_[i - 1].source &&
                           lost_[i].joint == lost_[i - 1].joint &&
                           lost_[i].row == lost_[i - 1].row + 1;
      run = goes_on ? run + 1.0 : 1.0;
      sum += 1.0;
      squares += 2.0 * run - 1.0;  // run^2 - (run - 1)^2
    }
    return sum > 0.0 ? squares / sum : 1.0;
  }

  /// How far from 1 is the share of each loss that the data want, in standard errors: median. A
  /// command is lost or it is not; what merely looks like holds wants a little more here and half
  /// as much there.
  double misfit(const std::vector<int>& losing) const {
    std::vector<double> out;
    for (const int joint : losing) {
      std::vector<Hunted> hunted;
      std::vector<std::vector<Change>> back;
      for (std::size_t s = 0; s < problem_.shots.size(); ++s) {
        const Shot& shot = problem_.shots[s];
        std::vector<Change> own;
        for (const LostCommand& l : lost_in(shot, joint)) own.push_back({l.row, 1});
        if (own.empty()) continue;
        hunted.push_back({s});
        back.push_back(std::move(own));
      }
      try_out(joint, hunted, back);
      for (const std::vector<Change>& of_shot : back) {
        for (const Change& c : of_shot) {
          // energy against the share is a parabola with this curvature: its lowest point
          if (c.made > least_gain_)
            out.push_back(std::abs(0.5 * (1.0 - c.energy / c.made) - 1.0) * std::sqrt(c.made));
        }
      }
    }
    return out.empty() ? INFINITY : median(out);
  }

  double position_energy(const VectorXd& projected) const {
    double sum = 0.0;
    for (const Shot& shot : problem_.shots) {
      for (std::size_t c = 0; c < problem_.channels.size(); ++c) {
        if (problem_.channels[c].signal != Signal::q) continue;
        sum += projected
                   .segment(static_cast<Index>(shot.offset + c * shot.rows),
                            static_cast<Index>(shot.rows))
                   .squaredNorm();
      }
    }
    return sum;
  }

  const Library& library_;
  Model model_;
  Problem problem_;
  StartElimination starts_;
  VectorXd r_, first_;  // with the losses found so far, and without
  SimParams params_;
  double tried_ = 1.0, least_gain_ = 0.0, best_gain_ = 0.0;
  std::vector<LostCommand> lost_;
  std::vector<double> response_;  // energy by squared jump of the command
};

}  // namespace

LossScore find_losses(const Surroundings& around, const FitResult& final) {
  return Hunt(around, final).all();
}

}  // namespace sanso::diagnose
