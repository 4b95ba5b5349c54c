// Lost commands: the hunt for them, and what is said of those found.
//
//   size    = lost / commands, among the commands whose loss would show (showing.h); Wilson's
//             interval, with as many events as independent runs of losses
//   misfit  = median over losses of |theta - 1| / sqrt(1 / made + wrong^2), theta the share of the
//             loss that the data want: with e = r'Mr, e(theta) is a parabola of curvature `made`
//             through e(0) and e(1), so that theta = (1 - (e(0) - e(1)) / made) / 2. Noise alone
//             would make its deviation 1 / sqrt(made), a thousandth where a loss shows well; what
//             such a loss changes is known only as well as the model (`loss_wrong`)
//   mirrored  a command that goes too far is a loss of share -1. In a robot that loses commands no
//             such mends anything to speak of; an error of another cause is mended by either
//   blind     whether commands whose loss shows little are lost as often, and every recording's as
//             often as any other's: chance does not choose
#include "tools/diagnose/explain/losses.h"

#include <algorithm>

#include "tools/diagnose/explain/hunt.h"
#include "tools/diagnose/explain/showing.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

using Eigen::VectorXd;

/// Candidates that lose commands, and that the model does not have.
std::vector<std::size_t> losing_candidates(const Surroundings& around, const Model& model) {
  const Library& library = *around.library;
  SimParams params = around.problem->sources.front().nominal;
  library.apply(model, params);
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < library.candidates.size(); ++i) {
    if (!model.has(i) && loses_commands(library[i], params)) out.push_back(i);
  }
  return out;
}

/// The smallest of the candidates that loses commands at all of these joints, if one does.
std::optional<std::size_t> smallest_at(const Library& library,
                                       const std::vector<std::size_t>& candidates,
                                       const std::vector<std::size_t>& losing) {
  std::optional<std::size_t> best;
  for (const std::size_t i : candidates) {
    const std::vector<std::size_t>& own = library[i].joints;
    const bool all = std::all_of(losing.begin(), losing.end(), [&](std::size_t j) {
      return std::find(own.begin(), own.end(), j) != own.end();
    });
    if (!all) continue;
    if (!best || own.size() < library[*best].joints.size()) best = i;
  }
  return best;
}

/// A command is lost or it is not; what merely looks like holds wants a little more here and half
/// as much there.
double misfit(const Hunt& hunt, const std::vector<std::size_t>& losing) {
  const double wrong = hunt.problem()->settings.chance.loss_wrong;
  std::vector<double> out;
  for (const std::size_t joint : losing) {
    for (const std::vector<Change>& of_shot : hunt.taken_back(joint)) {
      for (const Change& c : of_shot) {
        const double theta = 0.5 * (1.0 - c.energy / c.made);
        if (c.made > hunt.price().first)
          out.push_back(std::abs(theta - 1.0) / std::hypot(1.0 / std::sqrt(c.made), wrong));
      }
    }
  }
  return out.empty() ? INFINITY : median(out);
}

/// Of position errors in noise levels.
struct Energy {
  double sum = 0.0, rows = 0.0;
  double beyond_noise() const { return std::max(0.0, sum - rows); }
};

Energy position_energy(const Comparison& comparison, const VectorXd& projected) {
  Energy out;
  for (const Shot& shot : comparison.shots) {
    for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
      if (comparison.channels[c].signal != Signal::q) continue;
      out.sum += rows_of(projected, shot, c).squaredNorm();
      out.rows += static_cast<double>(shot.rows);
    }
  }
  return out;
}

/// What is told of losses by how each of them shows.
void count_what_shows(const Hunt& hunt, const std::vector<std::size_t>& losing, LossScore& out) {
  const Problem& problem = hunt.problem();
  const Showing showing(hunt, hunt.library()[out.candidate].joints);
  const auto [visible, hidden] = showing.count();
  out.seen = visible.lost;
  out.visible = visible.commands;
  out.unseen = showing.share_seen() < problem->settings.chance.loss_seen;
  const Interval interval = visible.interval(showing.run_effect());
  out.size = static_cast<double>(out.seen) / std::max(1, out.visible);
  out.low = interval.low;
  out.high = interval.high;
  out.blind = hidden.interval(1.0).low <= visible.interval(1.0).high &&
              showing.chance_of_spread() > problem->settings.decisions.family_wise;
  out.misfit = misfit(hunt, losing);
}

/// What is told of them where cycles without a reading say which they are: all of them show
/// together, and each is counted.
void count_unread(const Unread& unread, double wrong, LossScore& out) {
  out.seen = unread.lost;
  out.visible = unread.cycles;
  out.size = static_cast<double>(unread.lost) / std::max(1, unread.cycles);
  const Counted counted{unread.cycles, unread.lost};
  const Interval interval = counted.interval(unread.runs);
  out.low = interval.low;
  out.high = interval.high;
  out.blind = true;
  out.misfit = std::abs(unread.theta - 1.0) / std::hypot(1.0 / std::sqrt(unread.made), wrong);
}

LossScore score_of(const Hunt& hunt, std::size_t candidate,
                   const std::vector<std::size_t>& losing) {
  const Library& library = hunt.library();
  const Problem& problem = hunt.problem();
  LossScore out;
  out.candidate = candidate;
  out.lost = hunt.repaired().lost;
  if (hunt.with_readings())
    count_unread(*hunt.with_readings(), problem->settings.chance.loss_wrong, out);
  else
    count_what_shows(hunt, losing, out);
  out.p_family =
      std::min(1.0, problem->settings.decisions.family_wise * std::exp(-0.5 * hunt.best_gain()));
  out.mirrored = hunt.mirrored();
  const StartElimination& starts = hunt.starts();
  out.repaired = starts.project(hunt.repaired().r);
  const Energy before = position_energy(*problem, starts.project(hunt.error_before())),
               after = position_energy(*problem, out.repaired);
  out.energy = before.sum - after.sum;
  out.left_share = after.beyond_noise() / std::max(before.beyond_noise(), 1e-9);
  Surroundings around{problem, &library, starts, {}};
  around.set_shot_scale(starts.energy_by_shot(hunt.repaired().r));
  out.left = position_error_level(around, hunt.repaired().r, {});
  return out;
}

}  // namespace

bool loses_commands(const Candidate& c, const SimParams& params) {
  if (!c.random) return false;
  SimParams with = params;
  c.apply(with, c.probes.front());
  return std::all_of(c.joints.begin(), c.joints.end(),
                     [&](std::size_t j) { return with.joints[j].loss > params.joints[j].loss; });
}

std::optional<LossScore> find_losses(const Surroundings& around, const FitResult& final) {
  const Library& library = *around.library;
  const std::vector<std::size_t> candidates = losing_candidates(around, final.model);
  std::vector<std::size_t> joints, losing;
  for (const std::size_t i : candidates) {
    const Candidate& c = library[i];
    if (c.joints.size() == 1) joints.push_back(c.joints.front());
  }
  if (joints.empty()) return std::nullopt;
  Hunt hunt(around, final.model, joints);
  if (hunt.lost_with_readings(joints)) losing = joints;
  for (const std::size_t joint : joints) {
    if (losing.size() < joints.size() && hunt.lost_some(joint)) losing.push_back(joint);
  }
  if (losing.empty()) return std::nullopt;
  const std::optional<std::size_t> candidate = smallest_at(library, candidates, losing);
  if (!candidate) return std::nullopt;
  if (hunt.with_readings()) {
    hunt.forget_nuisances();
    for (int pass = 0; pass < around.settings().chance.loss_refits; ++pass) hunt.refit();
    return score_of(hunt, *candidate, losing);
  }
  // what merely looks like holds shows in the worst shots already, and so do losses of which
  // no run would show: no need to look through the rest
  LossScore worst = score_of(hunt, *candidate, losing);
  const double doubted =
      around.settings().chance.loss_doubted * around.settings().decisions.standard_errors;
  if (worst.unseen || worst.misfit > doubted ||
      worst.mirrored > around.settings().chance.loss_mirrored)
    return worst;
  hunt.forget_nuisances();
  for (const std::size_t joint : losing) hunt.take_all(joint);
  for (int pass = 0; pass < around.settings().chance.loss_refits; ++pass) {
    hunt.refit();
    const std::size_t before = hunt.repaired().lost.size();
    for (const std::size_t joint : losing) hunt.take_all(joint);
    if (hunt.repaired().lost.size() == before) break;
  }
  return score_of(hunt, *candidate, losing);
}

}  // namespace sanso::diagnose
