// Makes robot and session from the options, runs the trials that are missing, and shows the
// progress.
#include "host/app/learn_command.h"

#include <fmt/format.h>

#include <stdexcept>

#include "host/app/interrupt.h"
#include "host/app/motion_judge.h"
#include "host/learn/session/progress.h"
#include "host/learn/session/session.h"
#include "host/learn/session/summary.h"
#include "host/motion/motion.h"
#include "host/mpc/upper_layer.h"

namespace sanso::app {
namespace {

learn::Task task_of(const motion::Motion& motion) {
  return {motion.name, motion.primitives, motion.weights,
          [&motion](const learn::Episode& episode) { return broken_clauses(motion, episode); }};
}

learn::SessionSettings session_settings(const LearnOptions& options, const motion::Motion& motion,
                                        bool real_time) {
  learn::SessionSettings s;
  s.iterations = options.iterations;
  s.seed = options.seed;
  s.out = options.out;
  s.resume = options.resume;
  s.layers = layers_without(options.without);
  s.world = options.world;
  s.trial.watcher = options.watcher;
  s.trial.cost_limit = motion.stop.cost_limit;
  s.trial.tilt_limit_rad = motion.stop.tilt_limit_rad;
  s.trial.drop_limit_m = motion.stop.drop_limit_m;
  // of the 60 ms: leaves room for the way there and back and for a busy machine
  constexpr double kBudget_s = 0.045;
  s.trial.planning_budget_s = real_time ? kBudget_s : 0.0;
  return s;
}

std::string note_of(const learn::TrialSummary& t) {
  return fmt::format("trial {} cost {:.2f}{}  update {:.1f} ms  {:.1f} s", t.trial + 1, t.cost,
                     t.failed() ? std::string(" FAILED: ") + learn::to_string(t.end) : "",
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

int learn(const LearnOptions& options, const RobotFactory& make_robot) {
  const motion::Motion motion = motion::MotionLibrary().load(options.motion);
  const std::unique_ptr<learn::RobotAccess> robot = make_robot(options);
  mpc::MpcSettings mpc_settings;
  mpc_settings.threads = options.threads;
  mpc::UpperLayer upper(mpc_settings, host::AugmentedModel{});
  learn::Session session(task_of(motion), session_settings(options, motion, robot->real_time()),
                         *robot, upper);

  if (!options.quiet)
    fmt::print("{}: {} trials on {}, seed {}\n", motion.name, options.iterations,
               robot->description(), options.seed);
  const std::vector<learn::TrialSummary>& history = session.state().history;
  if (options.watcher) options.watcher->session_begins(motion.name, options.iterations, history);
  run_trials(session, motion.name, options);
  return !history.empty() && history.back().succeeded() ? 0 : 1;
}

}  // namespace sanso::app
