// Brings a controller through self-test and standing up into a trial, then feeds it fresh IMU
// samples and policies.
#include "tools/bench/tick_rig.h"

#include <cmath>

namespace sanso::bench {
namespace {

constexpr std::uint32_t kTrial = 1;

policy::Knot small_knot(double size) {
  policy::Knot knot;
  knot.u.setConstant(size);
  knot.x[model::kXPos + 2] = 0.245;
  knot.K.setConstant(size);
  return knot;
}

/// A long motion with as many basis functions as fit, moving slightly.
void fill(policy::PrimitiveSet& set) {
  set = policy::PrimitiveSet{};
  set.num_basis = policy::kMaxBasis;
  set.duration_s = 25.0;
  for (auto& scalar : set.scalar)
    for (auto& weight : scalar.weights) weight = 0.5f;
}

}  // namespace

Nanoseconds RigClock::thread_cpu() { return bench::thread_cpu(); }

TickRig::TickRig() : handover_(std::make_unique<firmware::Handover>()) {
  firmware::Settings settings;
  settings.bus.power_up_wait_s = 0;
  settings.guard.fall_height_m = 0;  // there is no ground to fall to
  controller_ = std::make_unique<firmware::Controller>(settings, bus_, clock_, *handover_);
}

void TickRig::publish_imu() {
  firmware::ImuSample& sample = handover_->imu.back();
  sample.time = now_;
  sample.sequence = sample.changes = ++imu_sequence_;
  const double wobble = 1e-3 * std::sin(0.1 * imu_sequence_);
  sample.quat_world_base = math::quat_exp({wobble, -wobble, 0.0});
  sample.gyro = {wobble, 0.0, -wobble};
  sample.accel = {0.0, wobble, 9.81};
  handover_->imu.publish();
}

void TickRig::publish_policy() {
  policy::UpperPolicy& policy = handover_->upper.back();
  policy.sequence = ++policy_sequence_;
  policy.trial_id = kTrial;
  policy.first_tick = controller_->observation().trial_tick + 2;
  policy.knots.clear();
  for (std::size_t k = 0; k < policy::kMaxUpperKnots; ++k)
    (void)policy.knots.try_push(small_knot(1e-4));
  handover_->upper.publish();
}

Nanoseconds TickRig::tick() {
  now_ += kTickPeriod;
  clock_.set(now_);
  publish_imu();
  if (controller_->state() == wire::SupervisorState::run && imu_sequence_ % kTicksPerUpper == 0)
    publish_policy();
  handover_->host_heard.store(now_);
  const Nanoseconds bus_before = bus_.cpu_ns(), before = clock_.thread_cpu();
  controller_->tick(now_);
  const Nanoseconds spent = clock_.thread_cpu() - before - (bus_.cpu_ns() - bus_before);
  wire::Observation observation;
  while (handover_->observations.pop(observation)) {
  }
  wire::CommandAck ack;
  while (handover_->acks.pop(ack)) {
  }
  firmware::LogRecord record;
  while (handover_->log.pop(record)) {
  }
  return spent;
}

bool TickRig::start_trial() {
  const auto reach = [&](wire::SupervisorState state) {
    for (int i = 0; i < 3000 && controller_->state() != state; ++i) tick();
    return controller_->state() == state;
  };
  fill(handover_->primitives.back());
  handover_->primitives.publish();
  policy::MiddleTable& table = handover_->middle.back();
  table.trial_id = kTrial;
  table.knots.clear();
  while (table.knots.try_push(small_knot(1e-4))) {
  }
  handover_->middle.publish();
  if (!reach(wire::SupervisorState::idle)) return false;
  handover_->commands.push({1, wire::CommandKind::arm, kTrial, policy::LayerSwitches::kAll, 0});
  if (!reach(wire::SupervisorState::hold)) return false;
  handover_->commands.push(
      {2, wire::CommandKind::start_trial, kTrial, policy::LayerSwitches::kAll, 1'000'000});
  return reach(wire::SupervisorState::run);
}

}  // namespace sanso::bench
