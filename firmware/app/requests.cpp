// What hosts and people ask of the controller, and why it is refused.
#include <algorithm>

#include "firmware/app/controller.h"
#include "firmware/bus/servos.h"
#include "shared/servo_bus/opencr.h"

namespace sanso::firmware {
namespace {

// the gate may open a little later than the command: readings have to be there first
constexpr int kGateTicks = 20;
// readings in a row before they are trusted with a goal
constexpr int kFreshTicks = 3;
// with the bus gone nothing can be lowered: the program ends with torque on
constexpr Nanoseconds kEndPatience = 3 * kSecond;

}  // namespace

void Controller::take_requests(Nanoseconds now) {
  // Count first: what was uploaded before a command was sent is then seen before the command.
  std::size_t commands = handover_.commands.size();
  trial_.take_uploads(handover_, supervisor_.state() == SupervisorState::run);
  take_emergency();
  take_end_request(now);
  wire::Command command;
  for (; commands > 0 && handover_.commands.pop(command); --commands) {
    const Refusal refusal = execute(command);
    // an arm command is answered when the torque is on, or when it cannot be
    const bool waits = command.kind == wire::CommandKind::arm && refusal == Refusal::none;
    if (!waits) acknowledge(command.sequence, refusal);
  }
  if (arm_wait_ticks_ >= 0) try_to_arm(now);
}

void Controller::acknowledge(std::uint32_t sequence, Refusal refusal) {
  (void)handover_.acks.push({sequence, static_cast<std::uint8_t>(refusal == Refusal::none ? 1 : 0),
                             supervisor_.state(), static_cast<std::uint16_t>(refusal)});
}

Refusal Controller::execute(const wire::Command& command) {
  switch (command.kind) {
    case wire::CommandKind::none:
      return Refusal::none;
    case wire::CommandKind::arm:
      return arm(command);
    case wire::CommandKind::start_trial:
      return start_trial(command);
    case wire::CommandKind::stop:
      return stop();
    case wire::CommandKind::disarm:
      return disarm(Event::disarm);
    case wire::CommandKind::clear_fault:
      return clear_fault();
    case wire::CommandKind::lower:
      return disarm(Event::lower);
    case wire::CommandKind::emergency_stop:
      handover_.emergency_stop.store(true);
      take_emergency();
      return Refusal::none;
  }
  return Refusal::wrong_state;
}

// --- people --------------------------------------------------------------------------------------

void Controller::take_emergency() {
  if (!handover_.emergency_stop.exchange(false)) return;
  enter_fault(Fault::emergency_stop, 0);
  // whatever the bookkeeping says: it costs nothing to say it again
  if (torque_ == Torque::off && !servos_.port_gone) (void)bus_.write_torque(false, servos_);
}

/// OpenCR's buttons, when they go down: User stops at once, Mode lowers. Reset is the board's own
/// (it cuts the supply), Start means nothing: no robot begins to move because somebody touches it.
void Controller::take_buttons(std::uint8_t down) {
  namespace opencr = servo_bus::opencr;
  const auto pressed = static_cast<std::uint8_t>(down & ~buttons_);
  buttons_ = down;
  if ((pressed & opencr::kButtonUser) != 0) handover_.emergency_stop.store(true);
  if ((pressed & opencr::kButtonMode) != 0) (void)disarm(Event::lower);
}

/// The program is to end: lower the robot first. What lowers is left_alone(); here is when it may.
void Controller::take_end_request(Nanoseconds now) {
  if (!handover_.end_requested.load(std::memory_order_relaxed)) return;
  if (!ending_) ending_since_ = now;
  ending_ = true;
  const SupervisorState state = supervisor_.state();
  const bool looking = state == SupervisorState::self_test && setup_.torque_found();
  const bool stuck = servos_.port_gone && now - ending_since_ > kEndPatience;
  if ((torque_ == Torque::off && !arming_.active() && !supervisor_.standing() && !looking) || stuck)
    handover_.may_end.store(true);
}

// --- arming --------------------------------------------------------------------------------------

Refusal Controller::arm(const wire::Command& command) {
  if (!supervisor_.allows(Event::arm) || torque_ != Torque::off || arm_wait_ticks_ >= 0)
    return Refusal::wrong_state;
  if (!trial_.has_primitives()) return Refusal::no_primitives;
  arm_command_ = command;
  arm_wait_ticks_ = 0;
  return Refusal::none;
}

/// Everything that must be true before a servo gets torque.
Refusal Controller::arming_gate(Nanoseconds now) const {
  if (ending_) return Refusal::ending;
  if (!handover_.arming_allowed.load(std::memory_order_relaxed)) return Refusal::no_realtime;
  if (fresh_ticks_ < kFreshTicks) return Refusal::servo_not_fresh;
  const ImuSample& imu = handover_.imu.front();
  if (!imu_new_ || now - imu.time > from_seconds(settings_.imu.late_s) || !estimator_.ready() ||
      !estimator_.healthy() || imu_watch_.reason() != 0)
    return Refusal::imu_not_fresh;
  if (estimator_.tilt() > settings_.guard.tilt_limit_rad) return Refusal::not_upright;
  for (std::size_t j = 0; j < model::kNumJoints; ++j) {
    const double q = servos_.servo[j].position_rad;
    if (q < model::kJoints[j].lower_rad - kFarOutside_rad ||
        q > model::kJoints[j].upper_rad + kFarOutside_rad)
      return Refusal::joint_range;
  }
  for (const ServoHealth& health : servos_.health)
    if (health.temperature_C >= settings_.guard.warm_temperature_C ||
        (health.voltage_V > 0 && health.voltage_V < settings_.guard.low_voltage_V) ||
        health.hardware_error != 0)
      return Refusal::hot_or_low;
  return Refusal::none;
}

void Controller::try_to_arm(Nanoseconds now) {
  const Refusal refusal = arming_gate(now);
  if (refusal == Refusal::none && supervisor_.apply(Event::arm)) {
    arm_wait_ticks_ = -1;
    trial_.set_layers(arm_command_.layers);
    arming_.begin();
  } else if (!supervisor_.allows(Event::arm) || ++arm_wait_ticks_ > kGateTicks) {
    end_arming(refusal == Refusal::none ? Refusal::wrong_state : refusal);
  }
}

/// The arm command under way is answered; without success the torque goes off again.
void Controller::end_arming(Refusal refusal) {
  arm_wait_ticks_ = -1;
  acknowledge(arm_command_.sequence, refusal);
  if (refusal == Refusal::none) return;
  if (torque_ == Torque::on) begin_release();
  arming_.cancel();
  (void)supervisor_.apply(Event::not_armed);
}

// --- trials, and the way down --------------------------------------------------------------------

Refusal Controller::start_trial(const wire::Command& command) {
  if (!supervisor_.allows(Event::start_trial)) return Refusal::wrong_state;
  if (ending_) return Refusal::ending;
  if (const Refusal refusal = trial_.check(command); refusal != Refusal::none) return refusal;
  if (!posture_.at_first_pose(trial_.first_pose())) return Refusal::start_pose;
  trial_.start(command);
  start_pending_ = true;  // this tick becomes trial tick 0
  return Refusal::none;
}

Refusal Controller::stop() {
  if (!supervisor_.allows(Event::stop)) return Refusal::wrong_state;
  start_pending_ = false;
  if (supervisor_.state() == SupervisorState::run) end_trial();
  return Refusal::none;
}

/// Down and torque off, by `event`: disarm, lower or left_alone.
Refusal Controller::disarm(Event event) {
  if (!supervisor_.allows(event)) return Refusal::wrong_state;
  if (supervisor_.state() == SupervisorState::fault) return lower_in_fault();
  if (supervisor_.state() == SupervisorState::idle) return Refusal::none;
  start_pending_ = false;
  trial_.end();
  if (arming_.active()) {  // nothing stands yet
    end_arming(Refusal::wrong_state);
    return Refusal::none;
  }
  if (!posture_.lowering()) posture_.begin_lowering(output_);
  supervisor_.apply(event);
  return Refusal::none;
}

Refusal Controller::lower_in_fault() {
  if (torque_ != Torque::on || servos_.port_gone) return Refusal::wrong_state;
  if (!output_known_) {  // found standing, and the start-up failed before it knew the goals
    if (!estimator_.ready()) return Refusal::servo_not_fresh;
    output_ = model::joints(x_);
    output_known_ = true;
  }
  if (fault_phase_ == FaultPhase::hold) begin_fault_phase(FaultPhase::lower);
  return Refusal::none;
}

/// Never lets a robot fall: while the servos hold it, it has to be lowered (or stopped by the
/// emergency stop) first.
Refusal Controller::clear_fault() {
  if (!supervisor_.allows(Event::clear_fault)) return Refusal::wrong_state;
  if (torque_ != Torque::off) return Refusal::torque_on;
  servos_ = ServoReadings{};
  setup_.restart();
  guard_.reset();
  estimator_ = Estimator(settings_.estimator);
  imu_watch_.reset();
  x_ = estimator_.state();
  trial_.end();
  foreign_seen_ = bus_.foreign();
  fresh_ticks_ = 0;
  output_known_ = false;
  self_test_begin_ = 0;
  supervisor_.apply(Event::clear_fault);
  return Refusal::none;
}

void Controller::end_trial() {
  trial_.end();
  posture_.begin_soft_stop(output_);
  supervisor_.apply(Event::trial_over);
}

}  // namespace sanso::firmware
