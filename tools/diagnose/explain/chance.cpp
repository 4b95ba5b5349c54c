// The judgement of chance: lost commands one by one (losses.h), then everything that makes readings
// scatter (scatter.h). What chance explains has no place in a prediction; it stands in
// Selection::expected_scatter, squares by entry, S in  E[r^2] = 1 + S.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/diagnose/explain/losses.h"
#include "tools/diagnose/explain/scatter.h"
#include "tools/diagnose/explain/steps.h"

namespace sanso::diagnose {
namespace {

bool stands_in(const Candidate& other, const Candidate& own) {
  const bool known = std::find(own.confounders.begin(), own.confounders.end(), other.effect) !=
                     own.confounders.end();
  return known && (other.joints == own.joints || other.joints.size() > own.joints.size());
}

/// Takes accepted effects that stood in for a random one's mean out of the model, where predictions
/// lose nothing.
void drop_stand_ins(SearchState& state, const Candidate& own) {
  Selection& found = state.found;
  for (std::size_t i = 0; i < found.accepted.size();) {
    const FitResult reduced = state.without(i);
    const Eigen::VectorXd energy = heldout_energy(*found.around, reduced);
    const HeldoutGain gain = compare(*state.problem, energy, found.final_heldout);
    if (!stands_in(state.accepted(i), own) ||
        (gain.beyond_chance() && gain.removed() > state.practical())) {
      ++i;
      continue;
    }
    state.say("stood in for the mean of " + own.title() + ": " + state.accepted(i).title());
    found.accepted.erase(found.accepted.begin() + static_cast<std::ptrdiff_t>(i));
    found.final = reduced;
    found.final_heldout = energy;
  }
}

/// A random effect into the model, with the scatter that it explains.
void accept_random(SearchState& state, const ScatterScore& score) {
  Selection& found = state.found;
  const Candidate& own = state.candidate(score.candidate);
  std::vector<double> theta = own.probes.front();
  theta.front() = score.size;
  Model model = found.final.model;
  model.effects.push_back({score.candidate, theta});
  state.problem = resmoothed(state.problem, jitter_of(*state.problem, state.library, model));
  found.around = make_surroundings(state.problem, state.library, model);
  found.final = fit(*found.around, model, state.problem->settings.fitting.steps_without);
  found.final_heldout = heldout_energy(*found.around, found.final);
  drop_stand_ins(state, own);
  Accepted entry;
  entry.candidate = score.candidate;
  entry.p_family = score.p_family;
  entry.low = score.low;
  entry.high = score.high;
  found.accepted.push_back(std::move(entry));
  if (found.expected_scatter.size() == 0)
    found.expected_scatter = Eigen::VectorXd::Zero(found.final.r.size());
  if (score.expected.size() > 0) found.expected_scatter += score.expected;
  state.relinearise();
  backward(state, 1);
}

/// What commands that go too far may mend of what losses do: where many are lost, a change too far
/// between two of them takes up a little of both.
double mirror_allowed(const ChanceSettings& settings, double lost) {
  return settings.loss_mirrored *
         std::clamp(lost / settings.mirrored_from, settings.mirrored_alone, 1.0);
}

/// The gate that lost commands fail; empty: none.
std::string refused_by(const SearchState& state, const LossScore& found) {
  const CandidateParameter& parameter = state.candidate(found.candidate).parameters.front();
  if (found.unseen) return "refused: no run of losses there would show most of them";
  if (!found.blind) return "refused: chance does not choose what shows little, or a recording";
  if (found.misfit > state.decisions().standard_errors) return "refused: losses are whole";
  if (found.mirrored > mirror_allowed(state.problem->settings.chance, found.size))
    return "refused: commands that go too far would mend as much";
  if (found.left > state.decisions().adequate &&
      found.left_share > state.problem->settings.chance.loss_left)
    return "refused: more than noise is left";
  if (found.energy <= state.practical()) return "refused: changes less than what matters";
  if (found.low <= parameter.null || found.size >= parameter.high)
    return "refused: ends at a bound";
  return "";
}

/// Lost commands, one by one: named when what they explain matters and no more than noise is left
/// with them. True when they were.
bool judge_losses(SearchState& state) {
  const std::optional<LossScore> losses = find_losses(*state.found.around, state.found.final);
  if (!losses) return false;
  const LossScore& found = *losses;
  const std::string refused = refused_by(state, found);
  state.say(fmt::format(
      "lost commands: {}: {} found, {} of {} that would show: {:.3g} [{:.3g}, {:.3g}], p {:.3g}, "
      "misfit {:.2f}, mirrored {:.3f}, {:.2f} noise levels left ({:.3f} of what was), {}",
      state.candidate(found.candidate).title(), found.lost.size(), found.seen, found.visible,
      found.size, found.low, found.high, found.p_family, found.misfit, found.mirrored, found.left,
      found.left_share, refused.empty() ? "accepted" : refused));
  if (!refused.empty()) return false;
  ScatterScore s;
  s.candidate = found.candidate;
  s.size = found.size;
  s.low = found.low;
  s.high = found.high;
  s.p_family = found.p_family;
  accept_random(state, s);
  const Eigen::VectorXd projected = state.found.around->starts.project(state.found.final.r);
  const Eigen::VectorXd repaired =
      rescaled(*state.problem, found.repaired, floors(*state.problem), state.problem.scales);
  state.found.expected_scatter += (projected.cwiseAbs2() - repaired.cwiseAbs2()).cwiseMax(0.0);
  return true;
}

/// What makes readings scatter: of those measured, the one that brings what is left closest to
/// noise alone. A chance that would scatter more than was seen is none either.
bool judge_readings(SearchState& state) {
  constexpr std::uint64_t kStream = 1000;
  const std::vector<ScatterScore> scores =
      judge_scatter(*state.found.around, state.found.final, state.practical(),
                    Random(state.options.seed, kStream));
  const ScatterScore* best = nullptr;
  double closest = INFINITY;
  for (const ScatterScore& one : scores) {
    const bool measured = one.p_family < state.decisions().family_wise &&
                          one.energy > state.practical() && !one.beyond;
    const double left = std::isfinite(one.left) ? one.left : state.left_level({});
    state.say(fmt::format(
        "scatter: {}: score {:.1f}, p {:.3g}, size {:.3g} [{:.3g}, {:.3g}], {:.2f} noise levels "
        "left",
        state.candidate(one.candidate).title(), one.score, one.p_family, one.size, one.low,
        one.high, left));
    const double from_noise = std::abs(std::log(std::max(left, 1e-3)));
    if (measured && one.low > 0.0 && from_noise < closest) best = &one, closest = from_noise;
  }
  if (best == nullptr || closest > std::log(state.decisions().adequate)) return false;
  if (loses_commands(state.candidate(best->candidate), state.problem->sources.front().nominal))
    state.unpointed = best->candidate;
  accept_random(state, *best);
  return true;
}

}  // namespace

bool judge_chance(SearchState& state) {
  if (judge_losses(state)) return true;
  return state.left_level({}) > state.decisions().adequate && judge_readings(state);
}

}  // namespace sanso::diagnose
