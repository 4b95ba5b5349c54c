// What goes to the servos: targets, torque, and what happens to both while a fault is latched.
#include <algorithm>
#include <cmath>

#include "firmware/app/controller.h"
#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace {

namespace xm430 = servo_bus::xm430;
// torque off is said until every servo has confirmed it; a silent one is waited for no longer
constexpr int kReleaseTries = 50;
constexpr int kReleaseBurst = 4;
// with this share of the supply limbs are drawn in softly
constexpr double kTuckDuty = 0.3;
// one servo's temperature changes slowly: a change of duty may be lost and is said again
constexpr int kDutyRepeatTicks = 100;
constexpr int kDutyStep_raw = 9;  // 1 %

std::int32_t duty_raw(double duty) {
  return static_cast<std::int32_t>(std::lround(duty * servo_bus::kFullPwm_raw));
}

}  // namespace

model::Input Controller::choose_target() {
  layers_ = policy::LayerOutputs{};
  switch (supervisor_.state()) {
    case SupervisorState::run:
      layers_ = trial_.layers(x_);
      return layers_.sum() + posture_.fade_balance(trial_, x_);
    case SupervisorState::stand_up:
      if (arming_.active()) return output_;
      [[fallthrough]];
    case SupervisorState::hold:
    case SupervisorState::soft_stop:
      layers_.lower = posture_.step(trial_, x_);
      return layers_.lower;
    case SupervisorState::fault:
      if (torque_ == Torque::on && fault_phase_ != FaultPhase::hold)
        return posture_.step(trial_, x_);
      return output_;
    default:
      return output_;
  }
}

void Controller::command_servos(const model::Input& wanted) {
  if (!bus_in_use()) return;
  const SupervisorState state = supervisor_.state();
  if (torque_ == Torque::releasing) {
    release_step();
  } else if (state == SupervisorState::idle) {
    if (torque_ == Torque::on) {  // just lowered
      begin_release();
      release_step();
    }
  } else if (state == SupervisorState::fault) {
    react_to_fault(wanted);
  } else if (arming_.active()) {
    arm_step();
  } else if (torque_ == Torque::on) {
    output_ = guard_.limit(wanted, output_, joints_now(), verdict_.limits);
    write_goals(output_);
    write_duties();
    torque_ticks_ = std::min(torque_ticks_ + 1, 1'000'000);
  }
  if (torque_ == Torque::off) output_ = model::joints(x_);
  if (!servos_.port_gone && !release_in_silence() &&
      ++slow_read_tick_ % static_cast<unsigned>(settings_.bus.slow_read_every_ticks) == 0)
    bus_.slow_read(servos_);
}

/// Before the first estimate: where the servos were told to be.
model::Input Controller::joints_now() const {
  return estimator_.ready() ? model::Input(model::joints(x_)) : output_;
}

// --- torque on and off ---------------------------------------------------------------------------

ServoGoals Controller::goals_of(const std::array<std::int32_t, kNumServos>& raw) const {
  ServoGoals goals;
  for (int j = 0; j < model::kNumJoints; ++j)
    goals.legs[j] = servo_bus::position_rad(raw[static_cast<std::size_t>(j)]);
  for (std::size_t k = 0; k < kNumHeld; ++k)
    goals.held[k] = servo_bus::position_rad(raw[model::kNumJoints + k]);
  return goals;
}

/// Goal = present first, then torque, each confirmed: nothing moves when the torque comes on.
void Controller::arm_step() {
  for (std::size_t s = 0; s < kNumServos; ++s)
    duties_raw_[s] =
        duty_raw(guard_.allowed_duty(static_cast<double>(servos_.health[s].temperature_C)));
  const Arming::Progress progress = arming_.step(bus_, servos_, duties_raw_);
  const ServoGoals goals = goals_of(arming_.goals_raw());
  output_ = goals.legs;
  held_output_ = goals.held;
  if (arming_.torque_written() && torque_ != Torque::on) {
    torque_ = Torque::on;
    torque_since_ = previous_due_;
    torque_ticks_ = 1;
  }
  if (progress == Arming::Progress::failed) {
    end_arming(arming_.refusal());
  } else if (progress == Arming::Progress::done) {
    output_known_ = true;
    duty_age_ticks_ = 0;
    posture_.begin_stand_up(goals, trial_.first_pose());
    end_arming(Refusal::none);
  }
}

void Controller::begin_release() {
  torque_ = Torque::releasing;
  release_tries_ = 0;
}

/// While nobody confirms, every other handful of ticks asks nothing: replies that come too late
/// destroy the order itself.
bool Controller::release_in_silence() const {
  return torque_ == Torque::releasing && release_tries_ % (2 * kReleaseBurst) >= kReleaseBurst;
}

/// Torque off, read back from every servo that can be heard.
void Controller::release_step() {
  if (servos_.port_gone) return;
  (void)bus_.write_torque(false, servos_);
  if (release_in_silence()) {
    ++release_tries_;
    return;
  }
  ServoBlocks blocks;
  const int answered = bus_.read_block(xm430::kTorqueEnable.address, 1, blocks);
  bool any_on = false;
  for (std::size_t s = 0; s < kNumServos; ++s)
    any_on = any_on || (blocks.got[s] && blocks.data[s][0] != 0);
  ++release_tries_;
  const bool heard_enough =
      answered == kNumServos || (release_tries_ >= kReleaseTries && answered > 0);
  if (any_on || !heard_enough) return;
  torque_ = Torque::off;
  torque_ticks_ = 0;
  output_known_ = false;
}

// --- goals ---------------------------------------------------------------------------------------

void Controller::write_goals(const model::Input& legs) {
  std::array<std::int32_t, kNumServos> goals{};
  for (int j = 0; j < model::kNumJoints; ++j)
    goals[static_cast<std::size_t>(j)] = servo_bus::position_raw(legs[j]);
  std::size_t count = model::kNumJoints;
  if (supervisor_.state() == SupervisorState::stand_up) {
    held_output_ = guard_.limit_held(posture_.held_targets(), held_output_, verdict_.limits);
    for (const double target : held_output_) goals[count++] = servo_bus::position_raw(target);
  }
  (void)bus_.write_goals(std::span(goals).first(count));
}

/// Goal PWM by temperature; sent when it changes, and again now and then while it is reduced.
void Controller::write_duties() {
  bool changed = false, reduced = false;
  Arming::Duties wanted{};
  for (std::size_t s = 0; s < kNumServos; ++s) {
    const double duty = guard_.allowed_duty(static_cast<double>(servos_.health[s].temperature_C));
    wanted[s] = duty_raw(duty);
    reduced = reduced || duty < settings_.guard.max_duty;
    changed = changed || std::abs(wanted[s] - duties_raw_[s]) >= kDutyStep_raw;
  }
  verdict_.limits.add_if(reduced, Limit::derated);
  if (!changed && !(reduced && ++duty_age_ticks_ >= kDutyRepeatTicks)) return;
  duties_raw_ = wanted;
  duty_age_ticks_ = 0;
  (void)bus_.write_each(xm430::kGoalPwm.address, 2, duties_raw_);
}

// --- faults --------------------------------------------------------------------------------------

void Controller::begin_fault_phase(FaultPhase phase) {
  fault_phase_ = phase;
  if (phase == FaultPhase::lower) posture_.begin_lowering(output_);
  if (phase != FaultPhase::tuck) return;
  if (!output_known_ || settings_.guard.tuck_s <= 0) return begin_release();
  posture_.begin_tuck(output_, settings_.guard.tuck_s);
  duties_raw_.fill(duty_raw(kTuckDuty));
  (void)bus_.write_each(xm430::kGoalPwm.address, 2, duties_raw_);
}

void Controller::react_to_fault(const model::Input& wanted) {
  // with the port gone nothing can be sent: the servos hold their last goal
  if (torque_ != Torque::on || servos_.port_gone || !output_known_) return;
  if (fault_phase_ != FaultPhase::hold && posture_.arrived()) {
    begin_release();
    return release_step();
  }
  output_ = guard_.limit(wanted, output_, joints_now(), verdict_.limits);
  write_goals(output_);
  if (fault_phase_ != FaultPhase::tuck) write_duties();
}

}  // namespace sanso::firmware
