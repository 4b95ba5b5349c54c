// One tick from top to bottom: read, estimate, decide, limit, write, publish. Every early exit
// ends in a command inside the limits or in the safe posture.
#include "firmware/app/controller.h"

#include <algorithm>

namespace sanso::firmware {
namespace {

// a tick that begins this late counts as late
constexpr Nanoseconds kLateAfter = kTickPeriod / 2;
// the self-test waits this long for the first IMU sample
constexpr Nanoseconds kImuStart = 3 * kSecond;
// torque registers read before this may be from before
constexpr int kTorqueSettleTicks = 150;
// a lost port is asked for this often
constexpr unsigned kReopenTicks = 50;

}  // namespace

Controller::Controller(const Settings& settings, board::SerialPort& port, board::Clock& clock,
                       Handover& handover)
    : settings_(settings),
      clock_(clock),
      handover_(handover),
      bus_(settings.bus, port, clock),
      setup_(settings.bus),
      estimator_(settings.estimator),
      imu_watch_(settings.imu),
      guard_(settings.guard, settings.bus, settings.imu),
      board_imu_(settings.imu, handover.imu),
      trial_({settings.reflex.gain_rad, settings.reflex.sharpness}),
      posture_(settings.supervisor) {}

void Controller::tick(Nanoseconds now) {
  const Nanoseconds cpu_begin = clock_.thread_cpu();
  note_lateness(now);
  read_sensors(now);
  take_requests(now);
  judge(now);
  advance_state(now);
  const model::Input wanted = choose_target();
  command_servos(wanted);  // reached on every path: inside the limits, the held pose, or torque off
  publish(now, cpu_begin);
}

// --- sensors, judgement --------------------------------------------------------------------------

void Controller::note_lateness(Nanoseconds now) {
  late_ = previous_due_ != 0 && now - previous_due_ > kTickPeriod + kLateAfter;
  previous_due_ = now;
  late_ticks_ += late_ ? 1 : 0;
}

bool Controller::bus_in_use() const {
  const SupervisorState state = supervisor_.state();
  if (state == SupervisorState::self_test) return setup_.finished();
  return state != SupervisorState::boot;
}

void Controller::read_sensors(Nanoseconds now) {
  if (!release_in_silence() && (bus_in_use() || setup_.servos_heard())) {
    // arms and head are read until the robot stands; in a trial the legs have the bus for
    // themselves
    const SupervisorState state = supervisor_.state();
    const bool legs_only = state == SupervisorState::run || state == SupervisorState::hold ||
                           state == SupervisorState::soft_stop;
    const Nanoseconds asked = clock_.now();
    bus_.expect_torque(torque_ != Torque::off);
    bus_.read_feedback(legs_only ? model::kNumJoints : kNumServos, servos_);
    handover_.times.reply.add(clock_.now() - asked);
    fresh_ticks_ = servos_.answered == kNumServos ? std::min(fresh_ticks_ + 1, 1000) : 0;
    if (servos_.port_gone && slow_read_tick_++ % kReopenTicks == 0) (void)bus_.ready();
  }
  if (settings_.imu.from_board && !servos_.port_gone && !release_in_silence()) {
    if (const Result<BoardReading> board = bus_.read_board(); board.ok()) {
      board_imu_.take(now, *board);
      take_buttons(board->buttons);
    }
  }
  imu_new_ = handover_.imu.update();
  handover_.pose.update();
  if (!bus_in_use()) return;
  if (const Nanoseconds taken = handover_.imu.front().time; taken != 0)
    handover_.times.imu_age.add(clock_.now() - taken);
  x_ = estimator_.update(now, servos_, handover_.imu.front(), handover_.pose.front());
  if (estimator_.ready())
    imu_watch_.update(now, handover_.imu.front(), estimator_,
                      torque_ == Torque::on && !arming_.active());
}

void Controller::judge(Nanoseconds now) {
  verdict_ = GuardVerdict{};
  const SupervisorState state = supervisor_.state();
  if (!bus_in_use() || state == SupervisorState::self_test) return;
  const bool on = torque_ == Torque::on;
  GuardSituation situation;
  situation.now = now;
  situation.torque_expected = on && !arming_.active() && torque_ticks_ > kTorqueSettleTicks;
  situation.standing = on && estimator_.ready();
  situation.watch_held = state == SupervisorState::stand_up;
  situation.tilt = estimator_.tilt();
  situation.height = estimator_.height_above_soles();
  situation.estimate_healthy = estimator_.healthy();
  situation.late = late_;
  situation.bus_foreign = bus_.foreign() != foreign_seen_;
  situation.imu_reason = imu_watch_.reason();
  verdict_ = guard_.watch(situation, servos_, handover_.imu.front());
  if (state == SupervisorState::fault)
    escalate(verdict_);
  else if (verdict_.fault != Fault::none)
    enter_fault(verdict_.fault, verdict_.detail);
  else
    verdict_.limits.add_if(on && host_silent(now), Limit::host_silent);
}

/// A latched fault does not make the controller blind: who falls goes limp, and what must not go on
/// for ever is lowered.
void Controller::escalate(const GuardVerdict& verdict) {
  if (torque_ != Torque::on || servos_.port_gone || fault_phase_ == FaultPhase::tuck) return;
  if (verdict.fallen)
    begin_fault_phase(FaultPhase::tuck);
  else if (fault_phase_ == FaultPhase::hold && output_known_ &&
           (verdict.must_lower || reaction_of(supervisor_.fault()) == FaultReaction::lower ||
            left_alone(previous_due_)))
    begin_fault_phase(FaultPhase::lower);
}

void Controller::enter_fault(Fault fault, std::uint16_t detail) {
  start_pending_ = false;
  const bool was_arming = arming_.active();
  supervisor_.raise(fault, detail);
  if (was_arming || arm_wait_ticks_ >= 0) end_arming(static_cast<Refusal>(fault));
  fault_phase_ = FaultPhase::hold;
  if (torque_ != Torque::on) return;
  if (was_arming || fault == Fault::emergency_stop)
    begin_release();
  else if (reaction_of(fault) == FaultReaction::limp)
    begin_fault_phase(FaultPhase::tuck);
  else if (reaction_of(fault) == FaultReaction::lower && output_known_)
    begin_fault_phase(FaultPhase::lower);
}

// --- state ---------------------------------------------------------------------------------------

void Controller::self_test(Nanoseconds now) {
  if (self_test_begin_ == 0) self_test_begin_ = now;
  const BusSetup::Progress progress = setup_.step(bus_, now);
  if (setup_.torque_found() && torque_ == Torque::off && progress != BusSetup::Progress::running)
    adopt();
  if (progress == BusSetup::Progress::running) return;
  if (progress == BusSetup::Progress::failed)
    return enter_fault(setup_.fault(), setup_.fault_detail());
  const Nanoseconds heard = handover_.imu.front().time;
  const bool alive = heard != 0 && now - heard < from_seconds(settings_.imu.silent_s);
  const bool standing = torque_ == Torque::on;
  if (alive && (!standing || estimator_.ready()))
    supervisor_.apply(standing ? Event::adopted : Event::setup_done);
  else if (now - self_test_begin_ > kImuStart && !alive)
    enter_fault(Fault::imu_silent, 0);
}

/// The servos hold a robot that an earlier run has left standing: it goes on standing.
void Controller::adopt() {
  torque_ = Torque::on;
  torque_ticks_ = 1;
  torque_since_ = previous_due_;
  output_known_ = setup_.finished();
  if (!output_known_) return;  // what they hold is not known: nothing is written
  const ServoGoals goals = goals_of(setup_.goals_raw());
  output_ = goals.legs;
  held_output_ = goals.held;
  posture_.begin_hold(goals);
}

void Controller::advance_state(Nanoseconds now) {
  if (left_alone(now) && supervisor_.allows(Event::left_alone) && !posture_.lowering())
    (void)disarm(Event::left_alone);
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
      if (posture_.arrived() && !arming_.active())
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

bool Controller::left_alone(Nanoseconds now) const {
  if (torque_ != Torque::on) return false;
  const Nanoseconds heard = handover_.host_heard.load(std::memory_order_relaxed);
  return ending_ ||
         now - std::max(heard, torque_since_) > from_seconds(settings_.supervisor.left_alone_s);
}

}  // namespace sanso::firmware
