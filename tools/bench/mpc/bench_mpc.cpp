// Both solvers get the same states of one walk, in turn, so that a busy machine slows both.
#include "tools/bench/mpc/bench_mpc.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <vector>

#include "host/motion/motion.h"
#include "host/mpc/solver.h"
#include "host/mpc/upper_layer.h"
#include "shared/math/order_statistics.h"
#include "shared/model/step_batch.h"
#include "tools/bench/mpc/mujoco_phases.h"

namespace sanso::bench {
namespace {

double ms(Nanoseconds t) { return 1e-6 * static_cast<double>(t); }

TimeSummary summary_of(std::vector<double> t) {
  if (t.empty()) return {};
  const auto at = [&](double q) { return math::quantile_below(std::span(t), q); };
  return {at(0.5), at(0.99), at(1.0)};
}
double median_of(std::vector<double> t) { return summary_of(std::move(t)).p50; }

/// Times that the scheduler took a processor from one of our threads.
long preemptions() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_nivcsw;
}

host::ResidualNetwork plausible_network() {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  const auto fill = [&](auto& m, float scale) {
    m = m.NullaryExpr([&] { return scale * normal(random); });
  };
  host::ResidualNetwork n;
  fill(n.W1, 0.15f), fill(n.W2, 0.12f), fill(n.W3, 0.12f), fill(n.b1, 0.1f), fill(n.b2, 0.1f);
  n.output_scale.setConstant(0.001f);                    // m, rad
  n.output_scale.tail<model::kNv>().setConstant(0.02f);  // m/s, rad/s
  return n;
}

/// The states that updates start from: along the motion, each disturbed anew.
class Walk {
 public:
  explicit Walk(const BenchMpcOptions& o)
      : motion(motion::MotionLibrary().load(o.motion)),
        reference(motion.reference().x),
        size_(o.disturbance) {}
  mpc::PlanRequest next() {
    mpc::PlanRequest request;
    std::normal_distribution<double> normal;
    request.observed_tick = (count_ * mpc_ticks) % static_cast<int>(reference.size());
    request.plan_tick = request.observed_tick + mpc_ticks;
    model::Tangent d;
    for (int i = 0; i < mpc::kNdx; ++i)
      d[i] = size_ * normal(random_) * (i < model::kNv ? 0.01 : 0.08);
    d[2] *= 0.3;
    request.x_observed = model::plus(reference[static_cast<std::size_t>(request.observed_tick)], d);
    ++count_;
    return request;
  }
  int mpc_ticks = kTicksPerUpper;
  motion::Motion motion;
  std::vector<model::State> reference;

 private:
  double size_;
  int count_ = 0;
  std::mt19937 random_{2};
};

/// The peer on the problem of the update just planned.
class Peer {
 public:
  Peer(const BenchMpcOptions& o, const Walk& walk)
      : walk_(walk),
        pool_(o.mpc.threads, o.mpc.pin_threads),
        phases_(o.mpc.horizon, o.mpc.dt_s, o.mpc.difference_step, pool_),
        solver_(
            {o.mpc.max_iterations, o.mpc.convergence, o.mpc.regularization, o.mpc.input_limit_rad},
            phases_) {}

  mpc::SolveResult solve(int plan_tick, const model::State& x0) {
    mpc::ProblemContext& c = phases_.context();
    const auto at = [&](int tick) {
      return walk_.reference[std::min(static_cast<std::size_t>(tick), walk_.reference.size() - 1)];
    };
    for (int k = 0; k <= phases_.stages(); ++k) {
      const int tick = plan_tick + k * walk_.mpc_ticks;
      std::copy_n(at(tick).data(), mpc::kNx, c.x_ref[k]);
      if (k < phases_.stages())
        std::copy_n(at(tick + walk_.mpc_ticks / 2).data() + model::kXJoint, mpc::kNu,
                    c.stage[k].u_fixed);
    }
    std::copy_n(walk_.motion.weights.state.data(), mpc::kNdx, c.state_weight);
    std::copy_n(walk_.motion.weights.input.data(), mpc::kNu, c.input_weight);
    std::copy_n(x0.data(), mpc::kNx, solver_.trajectory().x[0]);
    for (auto& row : solver_.trajectory().u) std::fill(std::begin(row), std::end(row), 0.0);
    mpc::SolveResult result;
    const mpc::SpinPool::Session session(pool_);
    solver_.solve(0.0, 0, result);
    return result;
  }
  double step_us(const model::State& x) {
    std::vector<double> times;
    model::State next;
    const model::Input u = model::joints(x);
    for (int i = 0; i < 200; ++i) {
      const Nanoseconds start = mpc::steady_now();
      phases_.step(x.data(), u.data(), next.data());
      times.push_back(1e3 * ms(mpc::steady_now() - start));
    }
    return median_of(times);
  }

 private:
  const Walk& walk_;
  mpc::SpinPool pool_;
  MujocoPhases phases_;
  mpc::Solver solver_;
};

/// Our planner stopped after 1, 2, .. iterations: when does it reach a given cost?
class Stopped {
 public:
  Stopped(const BenchMpcOptions& o, const host::AugmentedModel& model,
          const mpc::TrialContext& trial) {
    for (int n = 1; n <= o.mpc.max_iterations; ++n) {
      mpc::MpcSettings settings = o.mpc;
      settings.max_iterations = n;
      planners_.push_back(std::make_unique<mpc::UpperLayer>(settings, model));
      planners_.back()->begin_trial(trial);
    }
  }
  /// Time of the shortest plan whose cost is not above `cost` [ms]; the longest plan's when none
  /// is.
  double time_to(double cost, const mpc::PlanRequest& request) {
    for (const auto& planner : planners_) {
      planner->plan(request, *plan_);
      if (plan_->cost_after <= cost) break;
    }
    return ms(plan_->timing.total);
  }

 private:
  std::vector<std::unique_ptr<mpc::UpperLayer>> planners_;
  std::unique_ptr<mpc::PlanResult> plan_ = std::make_unique<mpc::PlanResult>();
};

/// Median time of one evaluation of f_A in one of eight lanes, standing on both feet.
double dynamics_eval_us(const host::AugmentedModel& model, const model::State& x, double dt_s) {
  auto xs = std::make_unique<model::StateLanes>();
  auto next = std::make_unique<model::StateLanes>();
  model::InputLanes u;
  model::ContactLanes contact;
  for (int l = 0; l < model::kLanes; ++l) {
    for (int i = 0; i < model::kNx; ++i) xs->v[i][l] = x[i];
    for (int i = 0; i < model::kNu; ++i) u.v[i][l] = x[model::kXJoint + i];
  }
  std::vector<double> times;
  for (int i = 0; i < 2000; ++i) {
    const Nanoseconds start = mpc::steady_now();
    model::step_batch(model.analytical, model.ground, xs.get(), &u,
                      {.h = dt_s, .substeps = model.substeps}, next.get(), &contact, 1);
    times.push_back(1e3 * ms(mpc::steady_now() - start) / model::kLanes);
  }
  return median_of(times);
}

/// Times of our updates, one entry an update.
struct Updates {
  std::vector<double> all, undisturbed, before, after;

  void add(const mpc::PlanResult& plan, bool quiet, const BenchMpcOptions& o, BenchMpcResult& r) {
    all.push_back(ms(plan.timing.total));
    if (quiet) undisturbed.push_back(all.back());
    before.push_back(plan.cost_before);
    after.push_back(plan.cost_after);
    r.iterations += plan.iterations / static_cast<double>(o.updates);
    r.cut_short += plan.stop == mpc::StopReason::deadline;
    r.max_iterations = std::max(r.max_iterations, static_cast<double>(plan.iterations));
    r.predict_ms += ms(plan.timing.predict) / o.updates;
    r.linearize_ms += ms(plan.timing.linearize) / o.updates;
    r.backward_ms += ms(plan.timing.backward) / o.updates;
    r.line_search_ms += ms(plan.timing.line_search) / o.updates;
  }
  void summarize(BenchMpcResult& r) const {
    r.update_ms = summary_of(all);
    r.undisturbed_ms = summary_of(undisturbed);
    r.undisturbed = static_cast<int>(undisturbed.size());
    r.cost_before = median_of(before);
    r.cost_after = median_of(after);
  }
};

/// The peer's solutions of some of the same problems, and our time to its cost.
class Comparison {
 public:
  Comparison(const BenchMpcOptions& o, const Walk& walk, const host::AugmentedModel& model,
             const mpc::TrialContext& trial)
      : peer_(o, walk), stopped_(o, model, trial) {}

  void add(const mpc::PlanRequest& request, const mpc::PlanResult& plan, BenchMpcResult& r) {
    const mpc::SolveResult solved = peer_.solve(request.plan_tick, plan.x_plan);
    ++r.peer_updates;
    times_.push_back(ms(solved.timing.total));
    after_.push_back(solved.cost_after);
    linearize_.push_back(ms(solved.timing.linearize) / std::max(1, solved.iterations));
    ratios_.push_back(times_.back() / ms(plan.timing.total));
    same_cost_ratios_.push_back(times_.back() / stopped_.time_to(solved.cost_after, request));
    r.peer_cheaper += solved.cost_after < plan.cost_after;
    r.peer_iterations += solved.iterations;
  }
  void summarize(const model::State& standing, BenchMpcResult& r) {
    r.peer_ms = summary_of(times_);
    r.peer_cost_after = median_of(after_);
    r.peer_iterations /= std::max(1, r.peer_updates);
    r.peer_step_us = peer_.step_us(standing);
    r.peer_linearize_ms = median_of(linearize_);
    r.ratio = median_of(ratios_);
    r.same_cost_ratio = median_of(same_cost_ratios_);
  }

 private:
  Peer peer_;
  Stopped stopped_;
  std::vector<double> times_, after_, linearize_, ratios_, same_cost_ratios_;
};

void choose_lanes(const std::string& lanes) {
  if (!lanes.empty() && !model::select_batch_isa(lanes.c_str()))
    throw std::invalid_argument(fmt::format(
        "--lanes {}: this processor or build lacks it; expected avx512, avx2 or portable", lanes));
}

}  // namespace

BenchMpcResult run_bench_mpc(const BenchMpcOptions& o) {
  BenchMpcResult r;
  choose_lanes(o.lanes);
  r.lanes = model::batch_isa();
  Walk walk(o);
  host::AugmentedModel model;
  if (o.residual) model.residual = plausible_network();
  mpc::UpperLayer upper(o.mpc, model);
  walk.mpc_ticks = std::max(1, static_cast<int>(std::lround(o.mpc.dt_s / to_seconds(kTickPeriod))));
  mpc::TrialContext trial;
  trial.reference = walk.reference;
  trial.weights = walk.motion.weights;
  upper.begin_trial(trial);
  std::unique_ptr<Comparison> comparison;
  if (o.peer) comparison = std::make_unique<Comparison>(o, walk, model, trial);

  r.threads = o.mpc.threads;
  r.updates = o.updates;
  Updates updates;
  mpc::PlanResult plan;
  for (int i = -20; i < o.updates; ++i) {  // the first ones warm caches and clock
    mpc::PlanRequest request = walk.next();
    request.time_budget = static_cast<Nanoseconds>(1e6 * o.budget_ms);
    const long taken_before = preemptions();
    upper.plan(request, plan);
    const bool quiet = preemptions() == taken_before;
    if (i < 0) continue;
    updates.add(plan, quiet, o, r);
    const bool compared = comparison && r.peer_updates < o.peer_updates &&
                          i % std::max(1, o.updates / o.peer_updates) == 0;
    if (compared) comparison->add(request, plan, r);
  }
  updates.summarize(r);
  r.dynamics_eval_us = dynamics_eval_us(model, walk.reference.front(), o.mpc.dt_s);
  if (comparison) comparison->summarize(walk.reference.front(), r);
  return r;
}

namespace {

nlohmann::json to_json(const TimeSummary& t) {
  return {{"p50", t.p50}, {"p99", t.p99}, {"max", t.max}};
}

void print_json(const BenchMpcResult& r) {
  nlohmann::json j = {{"update_ms", to_json(r.update_ms)},
                      {"update_undisturbed_ms", to_json(r.undisturbed_ms)},
                      {"updates", r.updates},
                      {"undisturbed", r.undisturbed},
                      {"ddp_iterations", r.iterations},
                      {"cut_short", r.cut_short},
                      {"threads", r.threads},
                      {"dynamics_eval_us", r.dynamics_eval_us},
                      {"predict_ms", r.predict_ms},
                      {"linearize_ms", r.linearize_ms},
                      {"backward_ms", r.backward_ms},
                      {"line_search_ms", r.line_search_ms},
                      {"cost_before", r.cost_before},
                      {"cost_after", r.cost_after},
                      {"lanes", r.lanes}};
  if (r.peer_updates > 0)
    j["peer"] = {{"update_ms", to_json(r.peer_ms)},
                 {"updates", r.peer_updates},
                 {"ddp_iterations", r.peer_iterations},
                 {"step_us", r.peer_step_us},
                 {"linearize_ms", r.peer_linearize_ms},
                 {"cost_after", r.peer_cost_after},
                 {"ratio", r.ratio},
                 {"same_cost_ratio", r.same_cost_ratio},
                 {"cheaper", r.peer_cheaper}};
  fmt::print("{}\n", j.dump(2));
}

void print_table(const BenchMpcResult& r) {
  fmt::print("policy update, {} updates, {} thread(s), {}\n", r.updates, r.threads, r.lanes);
  fmt::print("  update               p50 {:.2f}  p99 {:.2f}  max {:.2f} ms\n", r.update_ms.p50,
             r.update_ms.p99, r.update_ms.max);
  fmt::print(
      "  of these, {} that no other program interrupted: p50 {:.2f}  p99 {:.2f}  max {:.2f} ms\n",
      r.undisturbed, r.undisturbed_ms.p50, r.undisturbed_ms.p99, r.undisturbed_ms.max);
  fmt::print("  iterations           mean {:.2f}, most {:.0f};  cost {:.3f} -> {:.3f} (medians)\n",
             r.iterations, r.max_iterations, r.cost_before, r.cost_after);
  if (r.cut_short > 0)
    fmt::print("  {} updates used up their time budget and returned the best plan found\n",
               r.cut_short);
  fmt::print(
      "  mean of an update    predict {:.3f}  linearise {:.3f}  backward {:.3f}  roll-outs {:.3f} "
      "ms\n",
      r.predict_ms, r.linearize_ms, r.backward_ms, r.line_search_ms);
  fmt::print("  one dynamics step    {:.3f} us a lane\n", r.dynamics_eval_us);
  if (r.peer_updates == 0) return;
  fmt::print(
      "peer: iLQG on MuJoCo, same horizon, cost, step lengths and stopping rule, {} updates in "
      "the same run\n",
      r.peer_updates);
  fmt::print(
      "  update               p50 {:.1f}  p99 {:.1f}  max {:.1f} ms;  iterations {:.2f};  cost "
      "after {:.3f}\n",
      r.peer_ms.p50, r.peer_ms.p99, r.peer_ms.max, r.peer_iterations, r.peer_cost_after);
  fmt::print("  one dynamics step    {:.1f} us;  linearise {:.2f} ms\n", r.peer_step_us,
             r.peer_linearize_ms);
  fmt::print(
      "  peer / sanso         both to convergence {:.1f};  sanso stopped at the peer's cost "
      "{:.1f} (medians of the "
      "ratios)\n",
      r.ratio, r.same_cost_ratio);
  fmt::print("  the peer's cost, in its own model, was the lower one in {} of {} updates\n",
             r.peer_cheaper, r.peer_updates);
}

}  // namespace

int bench_mpc(const BenchMpcOptions& options) {
  const BenchMpcResult result = run_bench_mpc(options);
  options.json ? print_json(result) : print_table(result);
  return 0;
}

}  // namespace sanso::bench
