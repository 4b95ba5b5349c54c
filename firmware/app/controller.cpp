// One tick from top to bottom: read, estimate, decide, limit, write, publish. Every early exit
// ends in a command inside the limits or in the safe posture.
#include "firmware/app/controller.h"

#include <algorithm>
#include <array>

#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace {

// a tick that begins this late counts as late
constexpr Nanoseconds kLateAfter = kTickPeriod / 2;
// the self-test waits this long for the first IMU sample
constexpr Nanoseconds kImuStart = 3 * kSecond;
// torque registers read before this may be from before
constexpr int kTorqueSettleTicks = 150;
// a sync write has no reply: say it more than once
constexpr int kLimpRepeats = 5;

}  // namespace

Controller::Controller(const Settings& settings, board::SerialPort& port, board::Clock& clock,
                       Handover& handover)
    : settings_(settings),
      clock_(clock),
      handover_(handover),
      bus_(settings.bus, port, clock),
      setup_(settings.bus),
      estimator_(settings.estimator),
      guard_(settings.guard, settings.bus, settings.imu),
      board_imu_(settings.imu, handover.imu),
      trial_({settings.reflex.gain_rad, settings.reflex.sharpness}),
      posture_(settings.supervisor) {}

void Controller::tick(Nanoseconds now) {
  const Nanoseconds cpu_begin = clock_.thread_cpu();
  note_lateness(now);
  take_requests();
  read_sensors(now);
  judge(now);
  advance_state(now);
  const model::Input wanted = choose_target();
  command_servos(wanted);  // reached on every path: inside the limits, the held pose, or torque off
  publish(now, cpu_begin);
}

// --- requests ------------------------------------------------------------------------------------

void Controller::take_requests() {
  // Count first: what was uploaded before a command was sent is then seen before the command.
  std::size_t commands = handover_.commands.size();
  trial_.take_uploads(handover_, supervisor_.state() == SupervisorState::run);
  wire::Command command;
  for (; commands > 0 && handover_.commands.pop(command); --commands) {
    const Refusal refusal = execute(command);
    (void)handover_.acks.push({command.sequence,
                               static_cast<std::uint8_t>(refusal == Refusal::none ? 1 : 0),
                               supervisor_.state(), static_cast<std::uint16_t>(refusal)});
  }
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
      return disarm();
    case wire::CommandKind::clear_fault:
      return clear_fault();
  }
  return Refusal::wrong_state;
}

Refusal Controller::arm(const wire::Command& command) {
  if (!supervisor_.allows(Event::arm)) return Refusal::wrong_state;
  if (!trial_.has_primitives()) return Refusal::no_primitives;
  if (estimator_.tilt() > settings_.guard.tilt_limit_rad) return Refusal::not_upright;
  trial_.set_layers(command.layers);
  posture_.begin_stand_up(servos_, trial_.first_pose());
  arming_tick_ = 0;
  supervisor_.apply(Event::arm);
  return Refusal::none;
}

Refusal Controller::start_trial(const wire::Command& command) {
  if (!supervisor_.allows(Event::start_trial)) return Refusal::wrong_state;
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

Refusal Controller::disarm() {
  if (!supervisor_.allows(Event::disarm)) return Refusal::wrong_state;
  start_pending_ = false;
  trial_.end();
  if (!posture_.lowering()) posture_.begin_lowering(output_);
  supervisor_.apply(Event::disarm);
  return Refusal::none;
}

Refusal Controller::clear_fault() {
  if (!supervisor_.allows(Event::clear_fault)) return Refusal::wrong_state;
  if (servos_.port_gone) (void)bus_.reopen();
  (void)bus_.write_torque(false, servos_);
  servos_ = ServoReadings{};
  setup_.restart();
  guard_.reset();
  trial_.end();
  torque_ticks_ = 0;
  self_test_begin_ = 0;
  supervisor_.apply(Event::clear_fault);
  return Refusal::none;
}

void Controller::end_trial() {
  trial_.end();
  posture_.begin_soft_stop(output_);
  supervisor_.apply(Event::trial_over);
}

// --- sensors, judgement --------------------------------------------------------------------------

void Controller::note_lateness(Nanoseconds now) {
  const bool late = previous_due_ != 0 && now - previous_due_ > kTickPeriod + kLateAfter;
  previous_due_ = now;
  late_in_a_row_ = late ? late_in_a_row_ + 1 : 0;
  late_ticks_ += late ? 1 : 0;
}

bool Controller::bus_in_use() const {
  const SupervisorState state = supervisor_.state();
  return state != SupervisorState::boot && state != SupervisorState::self_test;
}

void Controller::read_sensors(Nanoseconds now) {
  if (bus_in_use()) {
    // arms and head are read until the robot stands; in a trial the legs have the bus for
    // themselves
    const SupervisorState state = supervisor_.state();
    const bool legs_only = state == SupervisorState::run || state == SupervisorState::hold ||
                           state == SupervisorState::soft_stop;
    bus_.read_feedback(legs_only ? model::kNumJoints : kNumServos, servos_);
  }
  if (settings_.imu.from_board && !servos_.port_gone) {
    if (const Result<BoardReading> board = bus_.read_board(); board.ok())
      board_imu_.take(now, *board);
  }
  handover_.imu.update();
  handover_.pose.update();
  x_ = estimator_.update(now, servos_, handover_.imu.front(), handover_.pose.front());
}

void Controller::judge(Nanoseconds now) {
  verdict_ = GuardVerdict{};
  if (!bus_in_use() || supervisor_.state() == SupervisorState::fault) return;
  GuardSituation situation;
  situation.now = now;
  situation.torque_expected = supervisor_.standing() && torque_ticks_ > kTorqueSettleTicks;
  situation.standing = supervisor_.standing() && estimator_.ready();
  situation.tilt = estimator_.tilt();
  situation.height = estimator_.height_above_soles();
  situation.estimate_healthy = estimator_.healthy();
  situation.late_in_a_row = late_in_a_row_;
  verdict_ = guard_.watch(situation, servos_, handover_.imu.front());
  if (verdict_.fault != Fault::none) enter_fault(verdict_.fault, verdict_.detail);
}

void Controller::enter_fault(Fault fault, std::uint16_t detail) {
  start_pending_ = false;
  limp_writes_ = 0;
  supervisor_.raise(fault, detail);
}

// --- state ---------------------------------------------------------------------------------------

void Controller::self_test(Nanoseconds now) {
  if (self_test_begin_ == 0) self_test_begin_ = now;
  switch (setup_.step(bus_, now)) {
    case BusSetup::Progress::running:
      return;
    case BusSetup::Progress::failed:
      return enter_fault(setup_.fault(), setup_.fault_detail());
    case BusSetup::Progress::done:
      break;
  }
  const Nanoseconds heard = handover_.imu.front().time;
  const bool alive = heard != 0 && now - heard < from_seconds(settings_.imu.silent_s);
  if (alive)
    supervisor_.apply(Event::setup_done);
  else if (now - self_test_begin_ > kImuStart)
    enter_fault(Fault::imu_silent, 0);
}

void Controller::advance_state(Nanoseconds now) {
  switch (supervisor_.state()) {
    case SupervisorState::boot:
      supervisor_.apply(Event::powered);
      break;
    case SupervisorState::self_test:
      self_test(now);
      break;
    case SupervisorState::run:
      if (host_silent(now) || trial_.over())
        end_trial();
      else
        trial_.advance();
      break;
    case SupervisorState::stand_up:
    case SupervisorState::soft_stop:
      if (posture_.arrived() && arming_tick_ < 0)
        supervisor_.apply(posture_.lowering() ? Event::lowered : Event::arrived);
      break;
    case SupervisorState::hold:
      if (start_pending_) {
        start_pending_ = false;
        trial_.advance();
        estimator_.set_origin_here();
        x_ = estimator_.state();
        supervisor_.apply(Event::start_trial);
      }
      break;
    case SupervisorState::idle:
    case SupervisorState::fault:
      break;
  }
}

bool Controller::host_silent(Nanoseconds now) const {
  const Nanoseconds heard = handover_.host_heard.load(std::memory_order_relaxed);
  return now - heard > from_seconds(settings_.supervisor.host_silent_s);
}

// --- output --------------------------------------------------------------------------------------

model::Input Controller::choose_target() {
  layers_ = policy::LayerOutputs{};
  switch (supervisor_.state()) {
    case SupervisorState::run:
      layers_ = trial_.layers(x_);
      return layers_.sum() + posture_.fade_balance(x_);
    case SupervisorState::stand_up:
      if (arming_tick_ >= 0) return model::joints(x_);
      [[fallthrough]];
    case SupervisorState::hold:
    case SupervisorState::soft_stop:
      layers_.lower = posture_.step(trial_, x_);
      return layers_.lower;
    default:
      return output_;
  }
}

void Controller::command_servos(const model::Input& wanted) {
  const SupervisorState state = supervisor_.state();
  if (!bus_in_use()) return;
  if (state == SupervisorState::idle) {
    if (torque_ticks_ > 0) switch_torque(false);  // just lowered
    output_ = model::joints(x_);
  } else if (state == SupervisorState::fault) {
    react_to_fault();
  } else if (arming_tick_ >= 0) {
    arm_step();
  } else {
    output_ = guard_.limit(wanted, output_, model::joints(x_), verdict_.limits);
    write_goals(output_);
    ++torque_ticks_;
  }
  if (++slow_read_tick_ % settings_.bus.slow_read_every_ticks == 0 && !servos_.port_gone)
    bus_.slow_read(servos_);
}

/// Goal = present first, then torque: nothing moves when the torque comes on.
void Controller::arm_step() {
  if (arming_tick_ == 0) {
    std::array<std::int32_t, kNumServos> goals{};
    for (std::size_t s = 0; s < kNumServos; ++s) goals[s] = servos_.servo[s].position_raw;
    (void)bus_.write_goals(goals);
  } else {
    switch_torque(true);
  }
  output_ = model::joints(x_);
  arming_tick_ = arming_tick_ < 2 ? arming_tick_ + 1 : -1;
}

void Controller::write_goals(const model::Input& legs) {
  std::array<std::int32_t, kNumServos> goals{};
  for (int j = 0; j < model::kNumJoints; ++j)
    goals[static_cast<std::size_t>(j)] = servo_bus::position_raw(legs[j]);
  std::size_t count = model::kNumJoints;
  if (supervisor_.state() == SupervisorState::stand_up) {
    const auto held = posture_.held_targets();
    for (std::size_t k = 0; k < kNumHeld; ++k) goals[count++] = servo_bus::position_raw(held[k]);
  }
  (void)bus_.write_goals(std::span(goals).first(count));
}

void Controller::switch_torque(bool on) {
  (void)bus_.write_torque(on, servos_);
  torque_ticks_ = on ? 1 : 0;
}

void Controller::react_to_fault() {
  const FaultInfo* info = info_of(supervisor_.fault());
  const bool limp = info == nullptr || info->reaction == FaultReaction::limp;
  if (servos_.port_gone) return;  // nothing can be sent: the servos hold their last goal
  if (limp) {
    if (limp_writes_++ < kLimpRepeats) switch_torque(false);
  } else if (torque_ticks_ > 0) {
    write_goals(output_);
  }
}

// --- report --------------------------------------------------------------------------------------

void Controller::publish(Nanoseconds now, Nanoseconds cpu_begin) {
  wire::Observation& o = observation_;
  const ImuSample& imu = handover_.imu.front();
  ++o.tick;
  o.time = now;
  o.trial_tick = supervisor_.state() == SupervisorState::run ? trial_.tick() : -1;
  o.trial_id = trial_.id();
  o.state = supervisor_.state();
  o.fault = static_cast<std::uint16_t>(supervisor_.fault());
  o.contact = estimator_.contact_bits();
  o.pose_age_ticks = estimator_.pose_age_ticks();
  o.x = x_;
  for (std::size_t j = 0; j < model::kNumJoints; ++j) {
    o.current_raw[j] = servos_.servo[j].current_raw;
    record_.position_raw[j] = servos_.servo[j].position_raw;
  }
  for (int a = 0; a < 3; ++a) {
    o.imu_acc[static_cast<std::size_t>(a)] = imu.accel[a];
    o.imu_gyro[static_cast<std::size_t>(a)] = imu.gyro[a];
  }
  report_supply(o);
  report_layers(now, o);
  o.limits = verdict_.limits.bits();
  o.late_ticks = late_ticks_;
  o.bus_lost = bus_.counters().lost;
  o.bus_corrupt = bus_.counters().corrupt;
  o.datagrams_dropped =
      handover_.datagrams_dropped.load(std::memory_order_relaxed) + trial_.stale_policies();
  o.tick_cpu_ns = static_cast<std::uint32_t>(clock_.thread_cpu() - cpu_begin);
  (void)handover_.observations.push(o);
  record_.observation = o;
  record_.fault_detail = supervisor_.fault_detail();
  (void)handover_.log.push(record_);
}

void Controller::report_supply(wire::Observation& o) const {
  float voltage = 0;
  o.max_temperature_C = 0;
  for (const ServoHealth& health : servos_.health) {
    if (health.voltage_V > 0)
      voltage = voltage > 0 ? std::min(voltage, health.voltage_V) : health.voltage_V;
    o.max_temperature_C = std::max(o.max_temperature_C, health.temperature_C);
  }
  o.voltage_V = voltage;
}

void Controller::report_layers(Nanoseconds now, wire::Observation& o) {
  const bool running = supervisor_.state() == SupervisorState::run;
  o.upper_sequence = trial_.upper_sequence();
  o.upper_age_ticks = trial_.upper_age_ticks();
  o.upper_weight = static_cast<float>(layers_.weight);
  o.u_upper = layers_.upper;
  o.u_middle = layers_.middle;
  o.u_lower = layers_.lower;
  o.u_out = output_;
  if (!running) return;
  const bool wanted = trial_.upper_wanted();
  verdict_.limits.add_if(wanted && !trial_.has_upper(), Limit::upper_missing);
  verdict_.limits.add_if(wanted && trial_.has_upper() && layers_.weight < 1.0, Limit::upper_stale);
  verdict_.limits.add_if(estimator_.pose_age_ticks() < 255 && estimator_.pose_age_ticks() > 10,
                         Limit::pose_stale);
  verdict_.limits.add_if(host_silent(now), Limit::host_silent);
}

}  // namespace sanso::firmware
