// The loop of linearise, backward pass and line search, and when it stops.
#include "host/mpc/solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/mpc/lane_kernels.h"

namespace sanso::mpc {

namespace {

constexpr int kMaxProposals = 4;     // regularizations tried at one linearisation
constexpr double kMuFactor = 100.0;  // between them
// first value that does something, per rad^2 of an input weight near 1
constexpr double kMuFloor = 1e-2;
// of the inputs that a plan begins with: after a push nothing may be better than the last plan
alignas(64) constexpr double kStartShares[kLineSearchLanes] = {1.0, 0.8, 0.6, 0.45,
                                                               0.3, 0.2, 0.1, 0.0};

/// Adds the time between construction and destruction to a counter.
class Stopwatch {
 public:
  explicit Stopwatch(Nanoseconds& sum) : sum_(sum), start_(steady_now()) {}
  ~Stopwatch() { sum_ += steady_now() - start_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  Nanoseconds& sum_;
  Nanoseconds start_;
};

}  // namespace

Nanoseconds steady_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Solver::Solver(const SolverSettings& settings, Phases& phases)
    : settings_(settings),
      phases_(phases),
      backward_pass_(lane_kernels().backward_pass),
      work_(std::make_unique<Workspace>()) {
  // touched here, so no page fault in solve()
  std::memset(static_cast<void*>(work_.get()), 0, sizeof(Workspace));
}

void Solver::solve(double sigma, Nanoseconds deadline, SolveResult& result) {
  result = SolveResult{};
  const Nanoseconds start = steady_now();
  mu_ = settings_.regularization;
  phases_.begin_solve();
  if (!roll_out_start(result)) return;
  Nanoseconds slowest = 0;  // iteration so far
  while (result.iterations < settings_.max_iterations) {
    const Nanoseconds before = steady_now();
    if (deadline != 0 && before + slowest > deadline) {
      result.stop = StopReason::deadline;
      break;
    }
    const Step step = improve(sigma, result);
    if (step == Step::none) {
      result.stop = StopReason::no_descent;
      break;
    }
    ++result.iterations;
    if (step == Step::too_small) {
      result.stop = StopReason::converged;
      break;
    }
    slowest = std::max(slowest, steady_now() - before);
  }
  result.cost_after = cost_;
  result.expected_cost = cost_ + noise_cost_;
  result.timing.total = steady_now() - start;
}

bool Solver::roll_out_start(SolveResult& result) {
  const Stopwatch watch(result.timing.line_search);
  LinePolicy policy;
  policy.nominal = &work_->trajectory;
  policy.input_limit_rad = settings_.input_limit_rad;
  std::memset(work_->gains, 0, sizeof work_->gains);
  if (start_as_line()) policy.gains = work_->gains;
  phases_.roll_out(policy, kStartShares, work_->lanes);
  const int lane = cheapest_lane();
  result.cost_before = cost_ = work_->lanes.cost(lane);
  result.finite = std::isfinite(cost_);
  if (result.finite) take_lane(lane);
  std::memset(work_->gains, 0, sizeof work_->gains);
  std::memset(work_->taken, 0, sizeof work_->taken);
  std::memset(work_->noise, 0, sizeof work_->noise);
  return result.finite;
}

/// The start's inputs as a line from none to all of them, without feedback. False: they are zero.
bool Solver::start_as_line() {
  Trajectory& t = work_->trajectory;
  bool any = false;
  for (int k = 0; k < phases_.stages(); ++k) {
    for (int i = 0; i < kNu; ++i) {
      any = any || t.u[k][i] != 0.0;
      work_->gains[k].k[i] = std::exchange(t.u[k][i], 0.0);
    }
    std::copy_n(t.x[0], kNx, t.x[k + 1]);  // what a feedback of zero would compare with
  }
  return any;
}

Solver::Step Solver::improve(double sigma, SolveResult& result) {
  {
    const Stopwatch watch(result.timing.linearize);
    phases_.begin_linearize(work_->trajectory, work_->derivatives, work_->costs);
  }
  for (int proposal = 0; proposal < kMaxProposals; ++proposal) {
    if (propose(sigma, result)) {
      const double before = cost_ + noise_price();
      const int lane = try_step_lengths(result);
      const double after = work_->lanes.cost(lane) + work_->lanes.noise_cost(lane);
      if (after < before) {
        take_lane(lane);
        std::copy_n(work_->gains, phases_.stages(), work_->taken);
        mu_ = std::max(settings_.regularization, mu_ / kMuFactor);
        return before - after < settings_.convergence * before ? Step::too_small : Step::taken;
      }
    }
    mu_ = std::max(kMuFloor, mu_ * kMuFactor);
  }
  return Step::none;
}

bool Solver::propose(double sigma, SolveResult& result) {
  const Stopwatch watch(result.timing.backward);
  BackwardInput in;
  in.stages = phases_.stages();
  in.derivatives = work_->derivatives;
  in.costs = work_->costs;
  in.u = work_->trajectory.u;
  in.input_limit_rad = settings_.input_limit_rad;
  const NoiseColumns columns = phases_.noise_columns(sigma);
  has_columns_ = columns.count > 0;
  in.columns = has_columns_ ? &columns : nullptr;
  in.sigma = columns.of_input ? 0.0 : sigma;
  in.one_noise_channel = settings_.one_noise_channel;
  in.mu = mu_;
  in.wait_for = [](void* phases, int stage) { static_cast<Phases*>(phases)->wait_for(stage); };
  in.wait_context = &phases_;
  const bool ok = backward_pass_(in, {work_->gains, work_->noise, work_->columns}, work_->value).ok;
  phases_.finish_linearize();
  return ok;
}

int Solver::try_step_lengths(SolveResult& result) {
  const Stopwatch watch(result.timing.line_search);
  LinePolicy policy;
  policy.nominal = &work_->trajectory;
  policy.gains = work_->gains;
  policy.noise = work_->noise;
  policy.columns = columns();
  policy.input_limit_rad = settings_.input_limit_rad;
  phases_.roll_out(policy, kStepLengths, work_->lanes);
  return cheapest_lane();
}

int Solver::cheapest_lane() const {
  int best = 0;
  const auto merit = [&](int lane) {
    return work_->lanes.cost(lane) + work_->lanes.noise_cost(lane);
  };
  for (int lane = 1; lane < kLineSearchLanes; ++lane)
    if (!(merit(best) <= merit(lane))) best = lane;  // written so that a NaN loses
  return best;
}

double Solver::noise_price() const {
  double sum = 0;
  for (int k = 0; k < phases_.stages(); ++k) {
    sum += 0.5 * work_->noise[k].still;
    if (has_columns_) sum += 0.5 * work_->columns[k].at;
  }
  return sum;
}

void Solver::take_lane(int lane) {
  phases_.lane_taken(lane);
  cost_ = work_->lanes.cost(lane);
  noise_cost_ = work_->lanes.noise_cost(lane);
  const int stages = phases_.stages();
  for (int k = 0; k <= stages; ++k)
    for (int i = 0; i < kNx; ++i) work_->trajectory.x[k][i] = work_->lanes.x(k, i, lane);
  for (int k = 0; k < stages; ++k)
    for (int i = 0; i < kNu; ++i) work_->trajectory.u[k][i] = work_->lanes.u(k, i, lane);
}

}  // namespace sanso::mpc
