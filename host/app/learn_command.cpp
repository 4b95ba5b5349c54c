// Makes robot and session from the options, runs the trials that are missing, and shows the
// progress.
#include "host/app/learn_command.h"

#include <fmt/format.h>

#include <stdexcept>

#include "host/app/adopt.h"
#include "host/app/foot_lift.h"
#include "host/app/interrupt.h"
#include "host/app/motion_judge.h"
#include "host/learn/session/progress.h"
#include "host/learn/session/session.h"
#include "host/learn/session/summary.h"
#include "host/motion/motion.h"
#include "host/mpc/upper_layer.h"
#include "shared/grounds/ground_file.h"

namespace sanso::app {
namespace {

/// The planner's model with what a diagnosis confirmed, also for the learner to begin at; says what
/// it took.
std::string adopt_into(const LearnOptions& options, host::AugmentedModel& model,
                       learn::ModelLearningSettings& learning) {
  if (options.adopt.empty()) return {};
  model::ModelParameters theta =
      options.wheels ? model::skating_parameters() : model::nominal_parameters();
  const Adoption adoption = adopt(options.adopt, theta);
  model.analytical = model::make_step_model(theta);
  learning.origin = theta;
  if (!options.quiet) fmt::print("{}", told(adoption));
  std::string names;
  for (const std::string& name : adoption.adopted) names += (names.empty() ? "" : "; ") + name;
  return names;
}

learn::Task task_of(const motion::Motion& motion) {
  learn::Task task{
      motion.name, motion.primitives, motion.weights,
      [&motion](const learn::Episode& episode) { return broken_clauses(motion, episode); },
      lifted_share};
  if (motion.skate) task.push = learn::Push{motion.skate->push_m_s, motion.skate->push_s};
  return task;
}

/// An emulated robot stands where and on what the motion takes place, whatever its world.
void prepare_world(const motion::Motion& motion, LearnOptions& options) {
  if (motion.skate && options.ground == "plane") options.ground = motion.skate->ground;
  if (options.ground != "plane") options.world += "+" + options.ground;
  options.wheels = motion.skate.has_value();
  options.target_rate_rad_s = motion.target_rate_rad_s.value_or(0.0);
  if (options.wheels) options.world += "+wheels";
}

/// What the motion's file and the clock ask for, before anybody sets anything.
LearnSettings defaults_of(const motion::Motion& motion, bool real_time) {
  LearnSettings s;
  s.session.trial.cost_limit = motion.stop.cost_limit;
  s.session.trial.tilt_limit_rad = motion.stop.tilt_limit_rad;
  s.session.trial.drop_limit_m = motion.stop.drop_limit_m;
  if (motion.skate) {
    s.session.bring_up.on = false;  // its poses would roll away
    // goals that follow a fall lean the reference into the next one: on wheels nothing stops it
    s.session.goals.enabled = false;
    s.session.input_share_floor = 1.0;  // nor does anything stop what inputs push off
  }
  // of the 60 ms: leaves room for the way there and back and for a busy machine
  constexpr double kBudget_s = 0.045;
  s.session.trial.planning_budget_s = real_time ? kBudget_s : 0.0;
  return s;
}

std::string note_of(const learn::TrialSummary& t) {
  return fmt::format("trial {} cost {:.2f}{}  update {:.1f} ms  {:.1f} s", t.trial + 1, t.cost,
                     t.failed() ? " FAILED: " + learn::how_it_ended(t) : "",
                     learn::percentile(t.update_ms, 0.5), t.wall_s);
}

/// Throws std::runtime_error when a person has stopped the session before its last trial.
void run_trials(learn::Session& session, const std::string& motion, const LearnOptions& options) {
  const Interrupt interrupt;
  learn::SessionWatcher* const watcher = options.watcher;
  bool ended_by_watcher = false;
  learn::Progress progress(stdout, motion, options.iterations, session.finished_before());
  session.run(
      [&](const learn::TrialSummary& t) {
        if (!options.quiet) progress.update(static_cast<int>(t.trial) + 1, note_of(t));
        if (watcher) watcher->trial_ended(t);
      },
      [&] {
        ended_by_watcher = watcher && watcher->ends_session();
        return ended_by_watcher || Interrupt::requested();
      });
  if (ended_by_watcher) return;
  const auto done = static_cast<int>(session.state().history.size());
  if (done < options.iterations)
    throw std::runtime_error(fmt::format(
        "stopped after trial {} of {}; `sanso learn` with the same options, --out {} and --resume "
        "goes on",
        done, options.iterations, options.out.string()));
}

}  // namespace

learn::Layers layers_without(const std::vector<std::string>& names) {
  learn::Layers on;
  for (const std::string& name : names) {
    if (name == "lower")
      on.lower = false;
    else if (name == "middle")
      on.middle = false;
    else if (name == "upper")
      on.upper = false;
    else if (name == "residual")
      on.residual = false;
    else if (name == "stochastic")
      on.stochastic = false;
    else
      throw std::runtime_error("--without " + name +
                               ": expected lower, middle, upper, residual or stochastic");
  }
  return on;
}

LearnSettings settings_of(const LearnOptions& options, const motion::Motion& motion,
                          bool real_time) {
  const LearnSettings defaults = defaults_of(motion, real_time);
  LearnSettings s = defaults;
  s.mpc.threads = options.threads;
  apply_profile(options.profile, s);
  for (const std::string& assignment : options.set) apply_setting(assignment, s);
  s.session.changed = changed_settings(defaults, s);
  s.session.iterations = options.iterations;
  s.session.seed = options.seed;
  s.session.out = options.out;
  s.session.resume = options.resume;
  s.session.layers = layers_without(options.without);
  s.session.world = options.world;
  s.session.trial.watcher = options.watcher;
  return s;
}

int learn(const LearnOptions& given, const RobotFactory& make_robot) {
  LearnOptions options = given;
  const motion::Motion motion = motion::MotionLibrary().load(options.motion);
  prepare_world(motion, options);
  (void)settings_of(options, motion, false);  // a wrong name is told before a robot is asked for
  const std::unique_ptr<learn::RobotAccess> robot = make_robot(options);
  LearnSettings settings = settings_of(options, motion, robot->real_time());
  host::AugmentedModel model;
  if (options.wheels) model.analytical = model::make_step_model(model::skating_parameters());
  settings.session.adopted = adopt_into(options, model, settings.session.model);
  model.ground = grounds::load_ground(options.ground);
  mpc::UpperLayer upper(settings.mpc, model);
  learn::Session session(task_of(motion), settings.session, *robot, upper, model);

  if (!options.quiet)
    fmt::print("{}: {} trials on {}, seed {}\n", motion.name, options.iterations,
               robot->description(), options.seed);
  const std::vector<learn::TrialSummary>& history = session.state().history;
  if (options.watcher) options.watcher->session_begins(motion.name, options.iterations, history);
  run_trials(session, motion.name, options);
  return !history.empty() && history.back().succeeded() ? 0 : 1;
}

}  // namespace sanso::app
