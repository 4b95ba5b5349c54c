// A loop that waits for observations, records them, plans when a plan is due, and ends by the
// clock, by a fall or by a fault.
#include "host/learn/session/trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>

#include "host/learn/wall_clock.h"
#include "shared/policy/layer_sum.h"
#include "shared/policy/policy_bytes.h"

namespace sanso::learn {
namespace {

using wire::SupervisorState;

void require(Status status, const char* what, const link::RobotLink& robot) {
  if (status == Status::ok) return;
  std::string message = fmt::format("{}: {}", what, to_string(status));
  if (status == Status::rejected)
    message += fmt::format(", number {} (docs/faults.md)", robot.refusal());
  if (robot.latest().fault != 0)
    message +=
        fmt::format("; the controller is in fault {} (docs/faults.md)", robot.latest().fault);
  if (robot.latest().fault == kFaultEmergencyStop) throw StoppedBefore(message);
  throw TrialError(message);
}

void wait_for_state(link::RobotLink& robot, SupervisorState wanted, double patience_s,
                    const char* what) {
  const Nanoseconds give_up = robot.clock().now() + from_seconds(patience_s);
  for (robot.poll(); robot.latest().state != wanted; robot.wait_observation(give_up)) {
    if (robot.latest().state == SupervisorState::fault) {
      const std::string message = fmt::format(
          "{}: the controller went into fault {} (docs/faults.md)", what, robot.latest().fault);
      if (robot.latest().fault == kFaultEmergencyStop) throw StoppedBefore(message);
      throw TrialError(message);
    }
    if (robot.clock().now() >= give_up)
      throw TrialError(fmt::format("{}: still in state {} after {} s", what,
                                   static_cast<int>(robot.latest().state), patience_s));
  }
}

/// Angle between the verticals of two base orientations [rad]; heading does not count.
double tilt_between(const model::State& a, const model::State& b) {
  const math::Vec3 up_a = math::rotation_matrix(model::base_quat(a)).transpose().col(2);
  const math::Vec3 up_b = math::rotation_matrix(model::base_quat(b)).transpose().col(2);
  return std::acos(std::clamp(up_a.dot(up_b), -1.0, 1.0));
}

double tilt_rate(const model::State& x) { return x.segment<2>(model::kXOmega).norm(); }

/// True when the robot has been quiet for quiet_s, false when it was not within the patience or is
/// no longer in hold.
bool wait_until_quiet(link::RobotLink& robot, const model::State& first,
                      const TrialSettings& settings) {
  const Nanoseconds give_up = robot.clock().now() + from_seconds(settings.quiet_patience_s);
  // what has passed counts: a robot that settled quietly does not wait
  const auto wanted = std::lround(settings.quiet_s / to_seconds(kTickPeriod));
  long quiet = wanted;
  for (;;) {
    const wire::Observation& o = robot.latest();
    const bool calm = tilt_between(o.x, first) < settings.quiet_tilt_rad &&
                      tilt_rate(o.x) < settings.quiet_rate_rad_s;
    quiet = calm ? quiet + 1 : 0;
    if (quiet >= wanted) return true;
    if (o.state != SupervisorState::hold || robot.clock().now() >= give_up) return false;
    robot.wait_observation(give_up);
  }
}

/// Of all that was seen: the hold, from when nobody's hand is at the robot any more.
std::vector<wire::Observation> standing(const std::vector<wire::Observation>& all,
                                        const TrialSettings& settings) {
  std::vector<wire::Observation> seen;
  std::copy_if(all.begin(), all.end(), std::back_inserter(seen),
               [](const wire::Observation& o) { return o.state == SupervisorState::hold; });
  const auto held = std::lround(settings.let_go_s / to_seconds(kTickPeriod));
  seen.erase(seen.begin(), seen.begin() + std::min<std::ptrdiff_t>(held, std::ssize(seen)));
  return seen;
}

/// The trial under way: keeps what has been seen and sent, and judges it.
class Trial {
 public:
  Trial(link::RobotLink& robot, mpc::UpperLayer& upper, const TrialSetup& setup,
        const TrialSettings& settings)
      : robot_(robot), upper_(upper), setup_(setup), settings_(settings) {
    episode_.plans.reserve(
        static_cast<std::size_t>(setup.duration_ticks / settings.upper_period_ticks) + 2);
  }
  Episode run();

 private:
  const model::State& reference(int tick) const {
    return setup_.reference[std::min(static_cast<std::size_t>(std::max(tick, 0)),
                                     setup_.reference.size() - 1)];
  }
  void begin();
  bool collect();
  void judge(const wire::Observation& o);
  void plan_from(const wire::Observation& o);
  const policy::UpperPolicy* policy_in_use(const wire::Observation& o) const;
  void finish();
  void mark_late_plans();

  link::RobotLink& robot_;
  mpc::UpperLayer& upper_;
  const TrialSetup& setup_;
  const TrialSettings& settings_;
  Episode episode_;
  std::unique_ptr<mpc::PlanResult> plan_ = std::make_unique<mpc::PlanResult>();
  int next_step_ = 0;    // the next 60 ms step whose observation is judged
  int next_plan_ = 0;    // the next period of the upper layer whose observation is planned from
  bool running_ = true;  // as far as the observations tell
};

void Trial::begin() {
  mpc::TrialContext context;
  context.trial_id = setup_.trial_id;
  context.reference = setup_.reference;
  context.middle = setup_.layers.middle ? setup_.middle : nullptr;
  context.on = setup_.layers;
  // the pose that the controller keeps without primitives
  context.u_rest = model::joints(setup_.reference.front());
  context.weights = setup_.weights;
  context.weights.input *= setup_.input_share;
  upper_.begin_trial(context);
  if (settings_.watcher) settings_.watcher->trial_begins(setup_);
  robot_.take_observations();  // from before the trial: not part of it
  wire::Command start{.kind = wire::CommandKind::start_trial,
                      .trial_id = setup_.trial_id,
                      .layers = setup_.layers.mask()};
  start.duration_ticks = setup_.duration_ticks;
  require(robot_.command(start), "start of the trial", robot_);
}

/// Takes in what has arrived; false when nothing came for too long.
bool Trial::collect() {
  const Nanoseconds give_up = robot_.clock().now() + from_seconds(settings_.silence_limit_s);
  std::vector<wire::Observation> fresh = robot_.take_observations();
  if (fresh.empty()) {
    robot_.wait_observation(give_up);
    fresh = robot_.take_observations();
  }
  for (const wire::Observation& o : fresh) {
    const bool of_this_trial =
        o.trial_id == setup_.trial_id && o.trial_tick >= 0 && o.state == SupervisorState::run;
    if (of_this_trial) episode_.ticks.push_back(o);
    if (o.state == SupervisorState::fault) {
      episode_.end = TrialEnd::fault;
      episode_.fault = o.fault;
    }
    if (!of_this_trial && (!episode_.ticks.empty() || o.state == SupervisorState::fault))
      running_ = false;
  }
  return !fresh.empty() || robot_.clock().now() < give_up;
}

void Trial::judge(const wire::Observation& o) {
  const model::State& x_ref = reference(o.trial_tick);
  episode_.cost_terms.push_back(mpc::stage_cost(setup_.weights, o.x, x_ref, o.u_upper));
  episode_.cost += episode_.cost_terms.back();
  if (settings_.watcher) settings_.watcher->judged(episode_.cost);
  if (episode_.cost > settings_.cost_limit) episode_.end = TrialEnd::cost_limit;
  if (o.x[model::kXPos + 2] < x_ref[model::kXPos + 2] - settings_.drop_limit_m)
    episode_.end = TrialEnd::low_base;
  if (tilt_between(o.x, x_ref) > settings_.tilt_limit_rad) episode_.end = TrialEnd::tilt;
}

/// What the controller said it executes, among what was sent.
const policy::UpperPolicy* Trial::policy_in_use(const wire::Observation& o) const {
  return executed_policy(episode_, o);
}

void Trial::plan_from(const wire::Observation& o) {
  const Nanoseconds begin = robot_.clock().now();
  const double wall_begin_s = wall_s();
  mpc::PlanRequest request;
  request.observed_tick = o.trial_tick;
  request.x_observed = o.x;
  request.plan_tick =
      (o.trial_tick / settings_.upper_period_ticks + 1) * settings_.upper_period_ticks;
  request.in_use = policy_in_use(o);
  request.sequence = static_cast<std::uint32_t>(episode_.plans.size()) + 1;
  request.sigma = setup_.layers.stochastic ? setup_.sigma : 0.0;
  request.time_budget = from_seconds(settings_.planning_budget_s);
  upper_.plan(request, *plan_);
  // the old policy fades; the next observation gets another chance
  if (plan_->status != Status::ok) return;
  // what is predicted from next time is what the controller executes
  policy::round_to_wire(plan_->policy);
  // before a virtual clock lets its world run on
  const double planned_ms = 1e3 * (wall_s() - wall_begin_s);
  robot_.clock().finish_computation(begin, from_seconds(settings_.modelled_planning_s));
  robot_.send_policy(plan_->policy);
  if (settings_.watcher) settings_.watcher->planned(planned_ms);

  PlanRecord record;
  record.policy = plan_->policy;
  record.observed_tick = o.trial_tick;
  record.update_ms = planned_ms;
  record.cost_before = plan_->cost_before;
  record.cost_after = plan_->cost_after;
  record.gain_norm = plan_->gain_norm;
  episode_.plans.push_back(record);
}

/// A plan is late when the controller, at the plan's first tick, was still using an older one.
void Trial::mark_late_plans() {
  for (PlanRecord& plan : episode_.plans)
    for (const wire::Observation& o : episode_.ticks)
      if (o.trial_tick == plan.policy.first_tick && o.upper_sequence != plan.policy.sequence)
        plan.late = 1;
}

void Trial::finish() {
  if (running_ && episode_.end != TrialEnd::completed)
    // best effort: the guard watches too
    (void)robot_.command({.kind = wire::CommandKind::stop, .trial_id = setup_.trial_id});
  constexpr int kLastTicksMayBeLost = 3;
  const int last_tick = episode_.ticks.empty() ? 0 : episode_.ticks.back().trial_tick;
  if (episode_.end == TrialEnd::completed &&
      last_tick < setup_.duration_ticks - 1 - kLastTicksMayBeLost)
    episode_.end = TrialEnd::ended_early;
  mark_late_plans();
  for (const wire::Observation& o : episode_.ticks) {
    episode_.reference.emplace_back();
    Eigen::Map<Eigen::Matrix<float, model::kNx, 1>>(episode_.reference.back().data()) =
        reference(o.trial_tick).cast<float>();
  }
}

Episode Trial::run() {
  begin();
  while (running_ && episode_.end == TrialEnd::completed) {
    if (!collect()) {
      episode_.end = TrialEnd::link_lost;
      break;
    }
    if (episode_.ticks.empty() || episode_.end != TrialEnd::completed) continue;
    const wire::Observation newest = episode_.ticks.back();
    if (!running_) continue;
    if (newest.trial_tick >= next_step_ * kTicksPerUpper) {
      judge(newest);
      next_step_ = newest.trial_tick / kTicksPerUpper + 1;
      robot_.send_sign_of_life();  // policies may be off, late or lost
    }
    if (!setup_.layers.upper || episode_.end != TrialEnd::completed) continue;
    if (newest.trial_tick < next_plan_ * settings_.upper_period_ticks) continue;
    next_plan_ = newest.trial_tick / settings_.upper_period_ticks + 1;
    plan_from(newest);
  }
  finish();
  return std::move(episode_);
}

}  // namespace

void upload_primitives(link::RobotLink& robot, const policy::PrimitiveSet& set) {
  std::vector<std::uint8_t> bytes(policy::kMaxPrimitiveBytes);
  bytes.resize(policy::to_bytes(set, bytes));
  require(robot.upload(wire::UploadKind::primitives, bytes), "upload of the primitives", robot);
}

Preparation prepare_trial(link::RobotLink& robot, const TrialSetup& setup,
                          const TrialSettings& settings) {
  upload_primitives(robot, *setup.primitives);
  if (setup.layers.middle && setup.middle)
    require(robot.upload(*setup.middle), "upload of the middle layer", robot);
  require(robot.command({.kind = wire::CommandKind::arm,
                         .trial_id = setup.trial_id,
                         .layers = setup.layers.mask()}),
          "arm", robot);
  Preparation preparation;
  try {
    constexpr double kStandUp_s = 10.0;
    wait_for_state(robot, SupervisorState::hold, kStandUp_s, "standing up");
    const Nanoseconds settled = robot.clock().now() + from_seconds(settings.settle_s);
    while (robot.clock().now() < settled) robot.wait_observation(settled);
    preparation.quiet = wait_until_quiet(robot, setup.reference.front(), settings);
    wait_for_state(robot, SupervisorState::hold, 0.1, "settling");
  } catch (const TrialError& error) {
    if (robot.latest().fault != kFaultFallen) throw;
    preparation.seen = standing(robot.take_observations(), settings);
    throw FellBefore(error.what(), preparation);
  }
  preparation.seen = standing(robot.take_observations(), settings);
  return preparation;
}

Episode run_trial(link::RobotLink& robot, mpc::UpperLayer& upper, const TrialSetup& setup,
                  const TrialSettings& settings) {
  return Trial(robot, upper, setup, settings).run();
}

}  // namespace sanso::learn
