// Runs each case as whole trials, then prints one line a case; times are modelled on the virtual
// clock, never measured.
#include "tools/sanso/loop_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "host/learn/session/session.h"
#include "host/motion/motion.h"
#include "host/mpc/solver.h"
#include "shared/files/atomic_file.h"
#include "tools/inprocess/inprocess_access.h"
#include "tools/report/svg_chart.h"

namespace sanso::cli {
namespace {

constexpr int kPeriods[] = {6, 3, 2, 1};  // ticks
constexpr int kHorizons[] = {12, 20};
constexpr int kIterations[] = {1, 3, 10};
constexpr double kPushAt_s = 1.0, kPushFor_s = 0.1;
constexpr int kStandTicks = 400;  // 4 s: push after one, three to recover

/// One motion, ready for trials; the lower layer gives the motion, there is no middle layer yet
/// (first trial of a session).
class Task {
 public:
  Task(const std::string& name, int most_ticks)
      : motion_(motion::MotionLibrary().load(name)), access_("lab") {
    motion_.primitives = learn::from_origin(motion_.primitives);
    reference_ = learn::reference_of(motion_.primitives);
    setup_.primitives = &motion_.primitives;
    setup_.reference = reference_;
    setup_.weights = motion_.weights;
    setup_.layers.middle = false;
    setup_.duration_ticks = std::min(most_ticks, motion_.primitives.duration_ticks());
  }
  learn::Episode run(mpc::UpperLayer& upper, int period_ticks, std::uint64_t seed, double push_N) {
    learn::TrialSettings settings;
    settings.upper_period_ticks = period_ticks;
    settings.modelled_planning_s = 0.5 * period_ticks * to_seconds(kTickPeriod);
    link::RobotLink& link = access_.place(reference_.front(), seed);
    learn::prepare_trial(link, setup_, settings);
    emulator::EmulatedRobot& robot = access_.robot().robot();
    if (push_N != 0.0) {
      const Nanoseconds start = robot.now() + from_seconds(kPushAt_s);
      robot.push({push_N, 0, 0}, {0, 0, 0}, start, start + from_seconds(kPushFor_s));
    }
    return learn::run_trial(link, upper, setup_, settings);
  }

 private:
  motion::Motion motion_;
  std::vector<model::State> reference_;
  inprocess::InProcessAccess access_;
  learn::TrialSetup setup_;
};

/// Runs the trials of one case and adds them up.
class CaseRun {
 public:
  CaseRun(const LoopStudyOptions& options, const LoopCase& set) : options_(options) {
    outcome_.set = set;
    mpc::MpcSettings settings;
    settings.horizon = set.horizon;
    settings.max_iterations = set.iterations;
    settings.threads = options.threads;
    upper_ = std::make_unique<mpc::UpperLayer>(settings, host::AugmentedModel{});
  }
  void add(Task& task, double push_N, TaskOutcome& sum) {
    for (int seed = 1; seed <= options_.seeds; ++seed) {
      const Nanoseconds start = mpc::steady_now();
      const learn::Episode episode =
          task.run(*upper_, outcome_.set.period_ticks, static_cast<std::uint64_t>(seed), push_N);
      wall_s_ += to_seconds(mpc::steady_now() - start);
      simulated_s_ += static_cast<double>(episode.ticks.size()) * to_seconds(kTickPeriod);
      sum.cost += episode.cost / options_.seeds;
      sum.worst_cost = std::max(sum.worst_cost, episode.cost);
      sum.failed += episode.end != learn::TrialEnd::completed;
      for (const learn::PlanRecord& plan : episode.plans) {
        times_ms_.push_back(plan.update_ms);
        outcome_.late += plan.late;
      }
    }
  }
  LoopOutcome finish() {
    std::sort(times_ms_.begin(), times_ms_.end());
    const auto at = [&](double q) {
      return times_ms_[static_cast<std::size_t>(q * static_cast<double>(times_ms_.size() - 1))];
    };
    if (!times_ms_.empty()) {
      outcome_.update_p50_ms = at(0.5);
      outcome_.update_p99_ms = at(0.99);
      outcome_.update_max_ms = times_ms_.back();
    }
    outcome_.updates = static_cast<int>(times_ms_.size());
    outcome_.wall_per_simulated_s = simulated_s_ > 0 ? wall_s_ / simulated_s_ : 0;
    return outcome_;
  }
  LoopOutcome& outcome() { return outcome_; }

 private:
  const LoopStudyOptions& options_;
  LoopOutcome outcome_;
  std::unique_ptr<mpc::UpperLayer> upper_;
  std::vector<double> times_ms_;
  double wall_s_ = 0, simulated_s_ = 0;
};

std::vector<LoopCase> cases_of(const LoopStudyOptions& options) {
  if (options.only_default) return {LoopCase{}};
  std::vector<LoopCase> out;
  for (const int horizon : kHorizons)
    for (const int iterations : kIterations)
      for (const int period : kPeriods) out.push_back({period, horizon, iterations});
  return out;
}

std::string name_of(const LoopCase& c) {
  return fmt::format(
      "{:.2f} s, {}", 0.06 * c.horizon,
      c.iterations == 10 ? "to convergence" : fmt::format("{} iteration(s)", c.iterations));
}

void print_line(const LoopOutcome& r) {
  fmt::print(
      "| {} | {:.2f} | {} | {:.2f} | {} | {:.2f} | {} | {:.2f} | {:.2f} | {:.2f} | {} | {} | "
      "{:.2f} |\n",
      10 * r.set.period_ticks, 0.06 * r.set.horizon, r.set.iterations, r.squat.cost, r.squat.failed,
      r.push.cost, r.push.failed, r.update_p50_ms, r.update_p99_ms, r.update_max_ms, r.updates,
      r.late, r.wall_per_simulated_s);
  std::fflush(stdout);
}

nlohmann::json to_json(const LoopOutcome& r) {
  const auto task = [](const TaskOutcome& t) {
    return nlohmann::json{{"cost", t.cost}, {"worst_cost", t.worst_cost}, {"failed", t.failed}};
  };
  return {
      {"period_ms", 10 * r.set.period_ticks},
      {"horizon_s", 0.06 * r.set.horizon},
      {"iterations", r.set.iterations},
      {"squat", task(r.squat)},
      {"push", task(r.push)},
      {"update_ms", {{"p50", r.update_p50_ms}, {"p99", r.update_p99_ms}, {"max", r.update_max_ms}}},
      {"updates", r.updates},
      {"late_updates", r.late},
      {"wall_per_simulated_s", r.wall_per_simulated_s}};
}

/// Cost of the push over the period, one line per horizon and number of iterations.
std::string figure_of(const std::vector<LoopOutcome>& results) {
  report::LineChart chart;
  chart.title = "Closed loop, push while standing: cost over the period of the upper layer";
  chart.x_label = "period [ms]";
  chart.y_label = "cost J";
  for (const LoopOutcome& r : results) {
    const std::string name = name_of(r.set);
    if (chart.series.empty() || chart.series.back().name != name)
      chart.series.push_back(
          {.name = name, .x = {}, .y = {}, .dashed = r.set.horizon > 12, .markers = true});
    chart.series.back().x.push_back(10.0 * r.set.period_ticks);
    chart.series.back().y.push_back(r.push.cost);
  }
  return report::svg(chart);
}

}  // namespace

int bench_loop(const LoopStudyOptions& options) {
  Task squat("squat", 1 << 20), stand("stand", kStandTicks);
  std::vector<LoopOutcome> results;
  if (!options.json)
    fmt::print(
        "| period ms | horizon s | iterations | squat J | failed | push J | failed | update p50 "
        "ms | p99 | max | "
        "updates | late | wall s per simulated s |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const LoopCase& set : cases_of(options)) {
    CaseRun run(options, set);
    run.add(squat, 0.0, run.outcome().squat);
    run.add(stand, options.push_N, run.outcome().push);
    results.push_back(run.finish());
    if (!options.json) print_line(results.back());
  }
  if (options.json) {
    nlohmann::json all = nlohmann::json::array();
    for (const LoopOutcome& r : results) all.push_back(to_json(r));
    fmt::print("{}\n", all.dump(2));
  }
  if (!options.figure.empty()) files::write_atomically(options.figure, figure_of(results));
  return std::any_of(results.begin(), results.end(),
                     [](const LoopOutcome& r) { return r.late > 0; })
             ? 1
             : 0;
}

}  // namespace sanso::cli
