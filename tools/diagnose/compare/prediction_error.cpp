// Errors of the simulated shots, batch by batch on all cores, with every optional change of a pass
// in one place.
#include "tools/diagnose/compare/prediction_error.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/sim/follow.h"
#include "tools/diagnose/sim/memory.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

/// How a pass differs from the plain one.
struct Pass {
  double step_s = 0.0;  // 0: the search's
  std::function<void(Window&)> move_start = [](Window&) {};
  std::vector<char> wanted = {};        // by joint; empty: all
  std::uint64_t seed = 0;               // not 0: chance is drawn
  bool polled = false;                  // commands wait for servos that look now and then
  std::vector<LostCommand> lost = {};   // sorted
  std::vector<char> wanted_shots = {};  // by shot; empty: all
  const Remembered* known = nullptr;    // of the same shots
};

/// Shots of one recording: [begin, end); shots are sorted by source.
struct Batch {
  std::size_t source, begin, end;
};
std::vector<Batch> by_source(const Comparison& comparison) {
  std::vector<Batch> out;
  for (std::size_t i = 0; i < comparison.shots.size(); ++i) {
    const std::size_t source = comparison.shots[i].source;
    if (out.empty() || out.back().source != source) out.push_back({source, i, i});
    out.back().end = i + 1;
  }
  return out;
}

/// The commands of one recording as they were received; empty when none of `lost` is its own.
std::optional<Drive> drive_with_lost(const Drive& drive, std::size_t source,
                                     const std::vector<LostCommand>& lost) {
  std::optional<Drive> out;
  for (const LostCommand& l : lost) {
    if (l.source != source) continue;
    if (!out) out = drive;
    std::vector<double>& command = out->joints[l.joint].command;
    // switched off: nothing to hold
    if (std::isnan(command[l.row]) || std::isnan(command[l.row - 1])) continue;
    // in order: of two lost in a row the last one received stays
    command[l.row] = command[l.row - 1];
  }
  return out;
}

/// One recording of a pass, ready to be simulated.
struct Run {
  const Source* source = nullptr;
  std::optional<Drive> held;  // its commands, where some are lost
  SimParams params;
  SimOptions options;
  std::vector<std::size_t> shots;  // those that are wanted
  std::vector<Window> windows;     // theirs
  std::vector<InnerStates> starts;
  bool started = false;  // they are known
  double recalled_s = kNone;

  const Drive& drive() const { return held ? *held : source->drive; }
  Followed followed() const {
    return {&params, &drive(), options.motion, windows, options.random_seed, recalled_s};
  }
};

/// A servo that looks now and then, as often as the delay is long at least, takes a command up to
/// half its period early or late of the mean.
void poll(SimParams& params, double longest_s) {
  for (JointParams& joint : params.joints)
    joint.command_scatter =
        0.5 * std::min(joint.nominal.command_delay_s + joint.command_delay, longest_s);
}

Run make_run(const Problem& problem, const Library& library, const Model& model, const Pass& pass,
             const Batch& batch) {
  Run run;
  for (std::size_t i = batch.begin; i < batch.end; ++i) {
    if (!pass.wanted_shots.empty() && pass.wanted_shots[i] == 0) continue;
    run.shots.push_back(i);
    run.windows.push_back(problem->shots[i].window);
    pass.move_start(run.windows.back());
  }
  if (run.shots.empty()) return run;
  run.source = &problem->sources[batch.source];
  run.recalled_s = problem->recalled_s;
  run.held = drive_with_lost(run.source->drive, batch.source, pass.lost);
  run.params = run.source->nominal;
  library.apply(model, run.params);
  if (pass.polled) poll(run.params, problem->settings.tolerances.poll);
  run.options.motion = &run.source->motion;
  run.options.max_step_s = pass.step_s > 0.0 ? pass.step_s : problem->settings.fitting.search_step;
  run.options.wanted = pass.wanted;
  if (pass.seed != 0) run.options.random_seed = Random(pass.seed, batch.source).bits() | 1U;
  if (const auto* starts = pass.known ? pass.known->of(batch.source, run.params) : nullptr) {
    run.starts = *starts;
    run.started = true;
  }
  return run;
}

/// Inner states at the starts of all windows that are not known: recordings of equal robots in
/// step.
void follow_runs(std::vector<Run>& all) {
  std::vector<Run*> runs;
  for (Run& run : all) {
    if (!run.started) runs.push_back(&run);
  }
  std::vector<Followed> recordings;
  recordings.reserve(runs.size());
  for (const Run* run : runs) recordings.push_back(run->followed());
  const std::vector<std::vector<std::size_t>> groups = in_step(recordings);
  parallel_for(groups.size(), [&](std::size_t g) {
    std::vector<Followed> members;
    members.reserve(groups[g].size());
    for (const std::size_t i : groups[g]) members.push_back(recordings[i]);
    std::vector<std::vector<InnerStates>> starts =
        follow(members, runs[groups[g].front()]->options);
    for (std::size_t k = 0; k < members.size(); ++k)
      runs[groups[g][k]]->starts = std::move(starts[k]);
  });
}

void simulate_run(const Problem& problem, const Pass& pass, const Run& run, Eigen::VectorXd& r) {
  SimOptions options = run.options;
  options.starts = &run.starts;
  std::vector<Prediction> predictions = simulate(run.params, run.drive(), run.windows, options);
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    const std::size_t shot = run.shots[i];
    if (pass.seed != 0)
      add_reading_jitter(run.params, Random(pass.seed, problem->sources.size() + shot).bits(),
                         predictions[i]);
    whiten_residual(problem, problem->shots[shot], predictions[i], pass.wanted, r);
  }
}

/// One for each recording of which a shot is wanted; where its shots start is known.
std::vector<Run> make_runs(const Problem& problem, const Library& library, const Model& model,
                           const Pass& pass) {
  std::vector<Run> runs;
  for (const Batch& batch : by_source(*problem)) {
    Run run = make_run(problem, library, model, pass, batch);
    if (!run.shots.empty()) runs.push_back(std::move(run));
  }
  follow_runs(runs);
  return runs;
}

/// Writes the whitened error of the wanted joints into r. Recordings side by side: each writes its
/// own shots, so the result does not depend on the number of threads.
void one_pass(const Problem& problem, const Library& library, const Model& model, const Pass& pass,
              Eigen::VectorXd& r) {
  const std::vector<Run> runs = make_runs(problem, library, model, pass);
  parallel_for(runs.size(), [&](std::size_t i) { simulate_run(problem, pass, runs[i], r); });
}

/// By joint, not 0: some of `joints` hangs on the same branch of the tree. Empty (all) when
/// `joints` is.
std::vector<char> branches_with(const Comparison& comparison,
                                const std::vector<std::size_t>& joints) {
  if (joints.empty()) return {};
  const std::vector<TreeJoint>& tree = comparison.sources.front().nominal.tree.joints;
  const auto root = [&](std::size_t j) {
    while (tree[j].parent >= 0) j = tree[j].parent;
    return j;
  };
  std::vector<char> wanted(tree.size(), 0);
  for (std::size_t j = 0; j < tree.size(); ++j) {
    wanted[j] = std::any_of(joints.begin(), joints.end(),
                            [&](std::size_t i) { return root(i) == root(j); });
  }
  return wanted;
}

/// `base` with what a pass that differs from its at these joints only makes of their branches.
Eigen::VectorXd changed_error(const Problem& problem, const Library& library, const Model& model,
                              const Eigen::VectorXd& base, const std::vector<std::size_t>& joints,
                              Pass pass) {
  SimParams params = problem->sources.front().nominal;
  library.apply(model, params);
  if (params.supply_resistance == 0.0) pass.wanted = branches_with(*problem, joints);
  Eigen::VectorXd r = base;
  one_pass(problem, library, model, pass, r);
  return r;
}

}  // namespace

Remembered::Remembered(const Problem& problem, const Library& library, const Model& model,
                       const std::vector<char>& shots)
    : params_(problem->sources.size()),
      starts_(problem->sources.size()),
      known_(problem->sources.size(), 0) {
  Pass pass;
  pass.wanted_shots = shots;
  for (Run& run : make_runs(problem, library, model, pass)) {
    const std::size_t source = problem->shots[run.shots.front()].source;
    params_[source] = std::move(run.params);
    starts_[source] = std::move(run.starts);
    known_[source] = 1;
  }
}

const std::vector<InnerStates>* Remembered::of(std::size_t source, const SimParams& params) const {
  const bool same = known_[source] != 0 && remember_alike(params_[source], params);
  return same ? &starts_[source] : nullptr;
}

bool remember_alike(const Problem& problem, const Library& library, const Model& a,
                    const Model& b) {
  return std::all_of(problem->sources.begin(), problem->sources.end(), [&](const Source& source) {
    SimParams one = source.nominal, other = source.nominal;
    library.apply(a, one);
    library.apply(b, other);
    return remember_alike(one, other);
  });
}

Eigen::VectorXd prediction_error(const Problem& problem, const Library& library,
                                 const Model& model) {
  Eigen::VectorXd r(problem->size);
  one_pass(problem, library, model, {}, r);
  return r;
}

Eigen::VectorXd drawn_prediction_error(const Problem& problem, const Library& library,
                                       const Model& model, std::uint64_t seed) {
  Pass pass;
  pass.seed = seed;
  Eigen::VectorXd r(problem->size);
  one_pass(problem, library, model, pass, r);
  return r;
}

Eigen::VectorXd polled_prediction_error(const Problem& problem, const Library& library,
                                        const Model& model, std::uint64_t seed) {
  Pass pass;
  pass.seed = seed;
  pass.polled = true;
  Eigen::VectorXd r(problem->size);
  one_pass(problem, library, model, pass, r);
  return r;
}

Eigen::VectorXd prediction_error_near(const Problem& problem, const Library& library,
                                      const Model& model, const Eigen::VectorXd& base,
                                      const std::vector<std::size_t>& joints,
                                      const std::vector<char>& shots, const Remembered* known) {
  Pass pass;
  pass.wanted_shots = shots;
  pass.known = known;
  return changed_error(problem, library, model, base, joints, std::move(pass));
}

bool LostCommand::operator<(const LostCommand& other) const {
  return std::tie(source, joint, row) < std::tie(other.source, other.joint, other.row);
}

Problem with_lost(const Problem& problem, std::vector<LostCommand> lost) {
  std::sort(lost.begin(), lost.end());
  Comparison out = *problem;
  for (std::size_t i = 0; i < out.sources.size(); ++i) {
    Drive& drive = out.sources[i].drive;
    if (std::optional<Drive> held = drive_with_lost(drive, i, lost)) drive = std::move(*held);
  }
  return {std::make_shared<const Comparison>(std::move(out)), problem.scales, problem.correction};
}

Eigen::VectorXd prediction_error_with_lost(const Problem& problem, const Library& library,
                                           const Model& model, const Eigen::VectorXd& base,
                                           std::vector<LostCommand> lost,
                                           const std::vector<char>& wanted_shots,
                                           const std::vector<std::size_t>& joints) {
  Pass pass;
  std::sort(lost.begin(), lost.end());
  pass.lost = std::move(lost);
  pass.wanted_shots = wanted_shots;
  return changed_error(problem, library, model, base, joints, std::move(pass));
}

Problem step_corrected(const Problem& problem, const Library& library, const Model& model) {
  Problem out{problem.comparison, problem.scales};
  const FittingSettings& steps = out->settings.fitting;
  const double coarse = steps.search_step, fine = std::min(steps.fine_step, 0.5 * coarse);
  Eigen::VectorXd at_coarse(out->size), at_fine = at_coarse;
  parallel_for(2, [&](std::size_t i) {
    Pass pass;
    pass.step_s = i == 0 ? fine : coarse;
    one_pass(out, library, model, pass, i == 0 ? at_fine : at_coarse);
  });
  // r = measured - predicted: r(coarse) - r(0) = -(error per second of step) coarse, linear in the
  // step
  out.correction.error = (at_fine - at_coarse) * (coarse / (coarse - fine));
  for (const Shot& shot : out->shots) {
    for (std::size_t c = 0; c < out->channels.size(); ++c)
      rows_of(out.correction.error, shot, c) *= out.scales.sigma[c];
  }
  return out;
}

Eigen::VectorXd prediction_error_from_moved_start(const Problem& problem, const Library& library,
                                                  const Model& model,
                                                  std::optional<std::size_t> joint, double dq0,
                                                  double ddq0, const Remembered& known) {
  Eigen::VectorXd r(problem->size);
  Pass pass;
  pass.known = &known;
  pass.move_start = [&](Window& w) {
    for (std::size_t j = 0; j < w.q.size(); ++j) {
      if (joint && *joint != j) continue;
      w.q[j] += dq0;
      w.dq[j] += ddq0;
    }
  };
  one_pass(problem, library, model, pass, r);
  return r;
}

}  // namespace sanso::diagnose
