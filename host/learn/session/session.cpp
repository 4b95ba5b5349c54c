// Trial, store, learn, store: the state on disk is always that after a finished trial, and
// everything that follows is computed from it.
#include "host/learn/session/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "host/learn/seeds.h"
#include "host/learn/session/summary.h"
#include "host/learn/wall_clock.h"
#include "shared/files/atomic_file.h"
#include "shared/policy/layer_sum.h"
#include "shared/policy/policy_bytes.h"

namespace sanso::learn {
namespace {

namespace fs = std::filesystem;

fs::path state_file(const fs::path& out) { return out / "state.bin"; }
/// One file a round: a kill between model and state leaves the state's own model untouched.
fs::path model_file(const fs::path& out, std::uint32_t round) {
  return out / fmt::format("model_{:03d}.bin", round);
}

/// What must agree between the run that began a session and the one that continues it.
std::string identity_of(const Task& task, const SessionSettings& s) {
  return fmt::format(
      "motion {} seed {} world {} layers {}{}{} middle {} {} {} {} {} model {} {} {}{}{}{}",
      task.name, s.seed, s.world, s.layers.mask(), s.layers.residual ? "" : " no-residual",
      s.layers.stochastic ? "" : " no-stochastic", s.middle.learning_rate,
      s.middle.gain_rate_factor, s.middle.forgetting_rate, s.middle.max_gain_norm,
      s.middle.start_at_reference, s.learn_model_every, s.learn_first_after, s.learn_after_failures,
      s.bring_up.on ? " bring-up" : "", s.changed.empty() ? "" : " set " + s.changed,
      s.adopted.empty() ? "" : " adopted " + s.adopted);
}

ModelLearningSettings model_settings_of(const SessionSettings& settings) {
  ModelLearningSettings model = settings.model;
  model.use_residual = model.use_residual && settings.layers.residual;
  return model;
}

void check_table_fits(const Task& task) {
  const int knots = task.primitives.duration_ticks() / kTicksPerMiddle + 1;
  if (knots > static_cast<int>(policy::kMaxMiddleKnots))
    throw std::runtime_error(fmt::format(
        "motion {}: lasts {:.1f} s, the middle layer's table holds {:.1f} s; shorten the motion",
        task.name, task.primitives.duration_s,
        to_seconds(kMiddlePeriod) * static_cast<double>(policy::kMaxMiddleKnots)));
}

std::vector<model::State> at_middle_knots(const std::vector<model::State>& reference) {
  std::vector<model::State> out;
  for (std::size_t i = 0; i < reference.size(); i += kTicksPerMiddle) out.push_back(reference[i]);
  return out;
}

/// The first plan is still under way while the first knots pass, but in the hold before a trial the
/// robot stands by these knots alone. They take over the first plan's first knot, as a policy is
/// held beyond its ends; otherwise they never learn.
void continue_into_hold(std::vector<UpperSample>& samples) {
  const auto first = std::find_if(samples.begin(), samples.end(),
                                  [](const UpperSample& s) { return s.weight > 0.0; });
  if (first != samples.end()) std::fill(samples.begin(), first, *first);
}

/// What the robot did by itself: without the hold and the ticks in which a hand pushed it.
Episode without_hand(const Episode& episode, const std::optional<Push>& push) {
  Episode free = episode;
  if (!push) return free;
  const auto first = std::lround(push->push_s / to_seconds(kTickPeriod)) + 1;
  free.before.clear();
  std::erase_if(free.ticks, [first](const wire::Observation& o) { return o.trial_tick < first; });
  return free;
}

}  // namespace

policy::PrimitiveSet from_origin(policy::PrimitiveSet primitives) {
  for (std::size_t axis :
       {std::size_t{0}, std::size_t{1}}) {  // base x, y: the equations only know differences
    policy::ScalarPrimitive& p = primitives.scalar[axis];
    p.goal -= p.start;
    p.start = 0.0;
  }
  return primitives;
}

std::vector<model::State> reference_of(const policy::PrimitiveSet& primitives) {
  policy::PrimitivePlayer player;
  player.reset(primitives);
  std::vector<model::State> out{player.state()};
  while (!player.finished()) {
    player.step();
    out.push_back(player.state());
  }
  return out;
}

std::vector<UpperSample> upper_samples(const Episode& episode, bool first_knots_follow) {
  std::vector<UpperSample> out;
  for (const wire::Observation& o : episode.ticks) {
    if (o.trial_tick % kTicksPerMiddle != 0) continue;
    const auto knot = static_cast<std::size_t>(o.trial_tick / kTicksPerMiddle);
    // a lost observation leaves weight 0: nothing is learned there
    if (knot >= out.size()) out.resize(knot + 1);
    const policy::UpperPolicy* executed = executed_policy(episode, o);
    if (!executed) continue;
    out[knot].weight = o.upper_weight;
    policy::sample_upper(*executed, o.trial_tick, out[knot].knot);
  }
  if (first_knots_follow) continue_into_hold(out);
  return out;
}

double next_input_share(double share, const TrialSummary& trial, const SessionSettings& settings) {
  if (trial.failed()) return std::min(1.0, share / settings.input_share_step);
  if (trial.lifted_share < 0.0 || trial.lifted_share >= settings.lifted_least) return share;
  return std::max(settings.input_share_floor, share * settings.input_share_step);
}

double cost_of_truth(const Episode& episode, const mpc::CostWeights& weights) {
  if (episode.truth.size() != episode.ticks.size() || episode.ticks.empty()) return -1.0;
  double cost = 0.0;
  int next_step = 0;  // as the trial was judged
  for (std::size_t i = 0; i < episode.ticks.size(); ++i) {
    const wire::Observation& o = episode.ticks[i];
    if (o.trial_tick < next_step * kTicksPerUpper) continue;
    next_step = o.trial_tick / kTicksPerUpper + 1;
    const model::State x_ref =
        Eigen::Map<const Eigen::Matrix<float, model::kNx, 1>>(episode.reference[i].data())
            .cast<double>();
    cost += mpc::stage_cost(weights, episode.truth[i].x, x_ref, o.u_upper);
  }
  return cost;
}

Session::Session(const Task& task, const SessionSettings& settings, RobotAccess& robot,
                 mpc::UpperLayer& upper, const host::AugmentedModel& model)
    : task_(task),
      settings_(settings),
      robot_(robot),
      upper_(upper),
      state_(std::make_unique<SessionState>()),
      learner_(model, task.weights.state, model_settings_of(settings), settings.seed) {
  check_table_fits(task_);
  task_.primitives = from_origin(task_.primitives);
  const std::vector<model::State> reference = reference_of(task_.primitives);
  x_init_ = at_middle_knots(reference);
  if (!settings_.middle.start_at_reference) x_init_.assign(x_init_.size(), reference.front());

  fs::create_directories(settings_.out);
  const std::string identity = identity_of(task_, settings_);
  if (fs::exists(state_file(settings_.out))) {
    if (!settings_.resume)
      throw std::runtime_error(
          settings_.out.string() +
          ": holds a session already; continue it with --resume or name another folder");
    load_state(state_file(settings_.out), *state_);
    if (state_->identity != identity)
      throw std::runtime_error(fmt::format("{}: cannot resume: it holds \"{}\", asked for \"{}\"",
                                           settings_.out.string(), state_->identity, identity));
    if (state_->model_rounds > 0 || fs::exists(model_file(settings_.out, 0))) {
      learner_.load(model_file(settings_.out, state_->model_rounds));
      learner_.set_residual_trust(state_->residual);
      upper_.set_model(learner_.current());
    }
  } else {
    state_->identity = identity;
    state_->sigma = settings_.layers.stochastic ? learner_.sigma() : 0.0;
    state_->primitives = task_.primitives;
    start_middle_layer(x_init_, settings_.middle, state_->middle);
    if (const std::string world = robot_.world_file(); !world.empty())
      files::write_atomically(settings_.out / "world.toml", world);
  }
  finished_before_ = static_cast<int>(state_->next_trial);
}

Session::~Session() = default;

void Session::run(const std::function<void(const TrialSummary&)>& after_trial,
                  const std::function<bool()>& stop) {
  bool fresh = settings_.bring_up.on && state_->next_trial == 0 && state_->history.empty();
  SessionWatcher* const watcher = settings_.trial.watcher;
  while (static_cast<int>(state_->next_trial) < settings_.iterations && !stop()) {
    try {
      if (fresh) bring_up();
      fresh = false;
      after_trial(run_one());
    } catch (const StoppedBefore&) {
      if (!watcher || !watcher->stopped_by_viewer()) throw;  // the same trial again, when allowed
    }
  }
}

/// The model that trial 1 plans with, from poses that were held. A robot that falls in them tells
/// what it showed until then; one that cannot be armed ends the session, as before a trial.
void Session::bring_up() {
  link::RobotLink& link =
      robot_.place(shifted_stand({}), derived_seed(settings_.seed, 0, Stream::bring_up));
  const HeldPoses held = hold_poses(link, settings_.bring_up, settings_.trial);
  const BringUpModel model = begin_with(held, settings_.bring_up, learner_);
  state_->robot = robot_.condition();
  learner_.save(model_file(settings_.out, 0));
  upper_.set_model(learner_.current());
  write_bring_up(settings_.out / "bring_up.json", held, model);
}

TrialSummary Session::run_one() {
  const double begin = wall_s();
  const std::uint32_t trial = state_->next_trial;
  const std::vector<model::State> reference = reference_of(state_->primitives);
  const auto rounded_middle = std::make_unique<policy::MiddleTable>(state_->middle);
  // the controller refuses a table that belongs to another trial
  rounded_middle->trial_id = trial + 1;
  policy::round_to_wire(*rounded_middle);

  TrialSetup setup;
  setup.trial_id = trial + 1;
  setup.primitives = &state_->primitives;
  setup.reference = reference;
  setup.middle = rounded_middle.get();
  setup.weights = task_.weights;
  setup.layers = settings_.layers;
  setup.sigma = state_->sigma;
  setup.input_share = state_->input_share;
  setup.duration_ticks = state_->primitives.duration_ticks();

  robot_.set_condition(state_->robot);
  if (task_.push) robot_.lend_hand({task_.push->push_m_s, task_.push->push_s, hold_of(trial)});
  link::RobotLink& link =
      robot_.place(reference.front(), derived_seed(settings_.seed, trial, Stream::robot));
  Episode episode = run_episode(link, setup);
  episode.trial = trial;
  episode.seed = settings_.seed;
  robot_.add_measurements(episode);
  state_->robot = robot_.condition();

  TrialSummary summary = summarize(episode, *rounded_middle);
  summary.sigma = setup.sigma;
  summary.input_share = setup.input_share;
  summary.cost_true = cost_of_truth(episode, task_.weights);
  if (task_.broken_clauses && !episode.failed())
    summary.broken_clauses = task_.broken_clauses(episode);
  if (task_.lifted_share) summary.lifted_share = task_.lifted_share(episode);
  state_->input_share = next_input_share(state_->input_share, summary, settings_);
  learn_from(episode, reference);
  const Episode free = taught_by(episode);
  if (const auto losses = learner_.losses(free)) {
    summary.model_loss = losses->augmented;
    summary.model_loss_analytical = losses->analytical;
    summary.model_loss_initial = losses->initial;
    if (settings_.layers.stochastic && settings_.sigma_by_trials && !episode.failed())
      state_->sigma = sigma_of_loss(losses->augmented);
  }
  summary.residual_share = state_->residual.share;
  if (learner_.judge_residual(free)) upper_.set_model(learner_.current());
  state_->residual = learner_.residual_trust();
  summary.wall_s = wall_s() - begin;
  state_->history.push_back(summary);
  state_->next_trial = trial + 1;
  save_episode(trial_file(settings_.out, trial), episode);
  if (time_to_learn_model()) learn_model();
  store();
  return summary;
}

/// A robot that falls before its trial has failed it, with the hold as its data.
Episode Session::run_episode(link::RobotLink& link, const TrialSetup& setup) {
  try {
    Preparation preparation = prepare_trial(link, setup, settings_.trial);
    Episode episode = run_trial(link, upper_, setup, settings_.trial);
    episode.before = std::move(preparation.seen);
    episode.quiet_at_start = preparation.quiet;
    return episode;
  } catch (const FellBefore& fell) {
    Episode episode;
    episode.end = TrialEnd::fell_before;
    episode.fault = kFaultFallen;
    // no better than a trial that was stopped for its cost
    episode.cost = settings_.trial.cost_limit;
    episode.before = fell.preparation.seen;
    return episode;
  }
}

/// Strength of the hand that travels along.
double Session::hold_of(std::uint32_t trial) const {
  if (!task_.push || settings_.hand_fades_over <= 0) return 0.0;
  return std::max(0.0, 1.0 - static_cast<double>(trial) / settings_.hand_fades_over);
}

/// What of an episode tells something about the robot without a hand.
Episode Session::taught_by(const Episode& episode) const {
  Episode free = without_hand(episode, task_.push);
  if (hold_of(episode.trial) > 0.0 && !settings_.learn_model_in_hand) free.ticks.clear();
  return free;
}

/// After the third trial, every tenth, and every third failure in a row.
bool Session::time_to_learn_model() const {
  const int every = settings_.learn_model_every, failures = settings_.learn_after_failures;
  if (every <= 0) return false;
  if (state_->next_trial % static_cast<std::uint32_t>(every) == 0) return true;
  if (static_cast<int>(state_->next_trial) == settings_.learn_first_after) return true;
  int failed = 0;
  for (auto t = state_->history.rbegin(); t != state_->history.rend() && t->failed(); ++t) ++failed;
  return failures > 0 && failed > 0 && failed % failures == 0;
}

void Session::learn_from(const Episode& episode, const std::vector<model::State>& reference) {
  if (settings_.layers.middle)
    update_middle_layer(upper_samples(episode, settings_.middle.first_knots_follow), x_init_,
                        episode.failed(), settings_.middle, state_->middle);
  if (episode.failed() && settings_.layers.lower)
    adapt_goals(episode, reference, task_.primitives, settings_.goals, state_->primitives);
}

/// Identification, residual network, noise amplitude, from the stored episodes; the next trial
/// plans with the result.
void Session::learn_model() {
  std::vector<Episode> episodes;
  const auto newest = static_cast<std::uint32_t>(settings_.model.newest_episodes);
  for (std::uint32_t t = state_->next_trial > newest ? state_->next_trial - newest : 0;
       t < state_->next_trial; ++t) {
    episodes.push_back(taught_by(load_episode(trial_file(settings_.out, t))));
  }
  learner_.learn(episodes);
  // not enough data: nothing was learned
  if (learner_.rounds() == static_cast<int>(state_->model_rounds)) return;
  state_->model_rounds = static_cast<std::uint32_t>(learner_.rounds());
  if (settings_.layers.stochastic) state_->sigma = learner_.sigma();
  state_->residual = learner_.residual_trust();
  learner_.save(model_file(settings_.out, state_->model_rounds));
  upper_.set_model(learner_.current());
}

/// Called when episode and model are stored: the state that counts the trial as done. A kill before
/// repeats the trial.
void Session::store() {
  save_state(state_file(settings_.out), *state_);
  write_summary(settings_.out / "summary.json", task_.name, settings_, *state_,
                robot_.description());
}

}  // namespace sanso::learn
