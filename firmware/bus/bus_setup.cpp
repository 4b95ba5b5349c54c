// A state machine of one bus transaction a call; registers are read, those of the RAM written when
// different, and read back. What differs in the EEPROM is the owner's to write.
#include "firmware/bus/bus_setup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "firmware/bus/servos.h"
#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace {

namespace xm430 = servo_bus::xm430;
// wrong answers in a row: the servo is not as it should be, and it was not one bad reading
constexpr int kWrongAnswers = 5;
// silence, 2 s: lost replies and a servo that takes its time to boot must not stop the start-up
constexpr int kSilences = 200;
// torque on in some legs and off in others: so it is, or one reading was wrong
constexpr int kLooks = 3;
constexpr int kAsLongAsAPacket = servo_bus::kMinPacketBytes;

struct Wanted {
  const servo_bus::Register& reg;
  std::int64_t value;
};

bool in_eeprom(const servo_bus::Register& r) { return r.address < xm430::kFirstRamAddress; }

/// In this order: torque off first.
std::array<Wanted, 10> wanted_registers(const BusSettings& s) {
  return {{{xm430::kTorqueEnable, 0},
           {xm430::kReturnDelayTime, s.return_delay_raw},
           {xm430::kOperatingMode, xm430::kModePosition},
           {xm430::kDriveMode, 0},
           {xm430::kBusWatchdog, 0},
           {xm430::kPositionPGain, s.position_p_gain_raw},
           {xm430::kPositionIGain, 0},
           {xm430::kPositionDGain, 0},
           {xm430::kProfileVelocity, 0},
           {xm430::kProfileAcceleration, 0}}};
}

/// Makes a register of the RAM hold `value`: reads, writes only when it differs, reads back. One of
/// the EEPROM has to hold it already.
Status ensure(BusMaster& bus, std::uint8_t id, const Wanted& wanted) {
  const servo_bus::Register& r = wanted.reg;
  Result<std::int64_t> value = bus.read_register(id, r.address, r.size, r.is_signed);
  if (!value.ok()) return value.status();
  if (*value == wanted.value) return Status::ok;
  if (in_eeprom(r)) return Status::rejected;
  if (const Status status = bus.write_register(id, r.address, r.size, wanted.value);
      status != Status::ok)
    return status;
  value = bus.read_register(id, r.address, r.size, r.is_signed);
  if (!value.ok()) return value.status();
  return *value == wanted.value ? Status::ok : Status::rejected;
}

/// For a servo with torque on: its torque is left on, and a long return delay, which only costs
/// time, is no reason to refuse it.
Status ensure_alive(BusMaster& bus, std::uint8_t id, const Wanted& wanted) {
  const servo_bus::Register& r = wanted.reg;
  if (r.address == xm430::kTorqueEnable.address || r.address == xm430::kReturnDelayTime.address)
    return Status::ok;
  return ensure(bus, id, wanted);
}

/// A robot is held at this goal: the joint can be there.
bool can_be_held(int slot, std::int32_t goal_raw) {
  const double goal = servo_bus::position_rad(goal_raw);
  if (slot >= model::kNumJoints) return std::abs(goal) < kHeldRange_rad;
  const model::JointInfo& joint = model::kJoints[static_cast<std::size_t>(slot)];
  return goal > joint.lower_rad - kFarOutside_rad && goal < joint.upper_rad + kFarOutside_rad;
}

}  // namespace

BusSetup::Progress BusSetup::failed(Fault fault, std::uint16_t detail) {
  fault_ = fault;
  detail_ = detail;
  return Progress::failed;
}

/// Counted apart: after a long silence the first wrong answer is still the first.
BusSetup::Progress BusSetup::answered_wrongly(Fault fault, std::uint8_t id) {
  return ++wrongs_ < kWrongAnswers ? Progress::running : failed(fault, id);
}

BusSetup::Progress BusSetup::unanswered(Fault fault, std::uint8_t id) {
  return ++silences_ < kSilences ? Progress::running : failed(fault, id);
}

BusSetup::Progress BusSetup::step(BusMaster& bus, Nanoseconds now) {
  switch (stage_) {
    case Stage::listen:
      return listen(bus, now);
    case Stage::power:
      return switch_power(bus, now);
    case Stage::wait:
      if (now - power_time_ >= from_seconds(settings_.power_up_wait_s)) stage_ = Stage::find;
      return Progress::running;
    case Stage::find:
      return find_servo(bus);
    case Stage::registers:
      return set_registers(bus);
    case Stage::goals:
      return read_goals(bus);
    case Stage::finished:
      return Progress::done;
  }
  return Progress::done;
}

/// Two masters destroy each other's packets: the bus has to be silent before the first request. A
/// master sends whole packets, or, at another rate than ours, bytes again and again; a line that
/// only crackles once is listened to anew.
BusSetup::Progress BusSetup::listen(BusMaster& bus, Nanoseconds now) {
  const BusMaster::Heard heard = bus.listen();
  if (listen_begin_ == 0) {
    listen_begin_ = now;  // what came before is nobody's
  } else if (heard.bytes > 0) {
    const bool again = noise_bytes_ > 0;
    noise_bytes_ += heard.bytes;
    if (heard.packets > 0 || again || noise_bytes_ >= kAsLongAsAPacket)
      return failed(Fault::bus_foreign, static_cast<std::uint16_t>(std::min(noise_bytes_, 0xffff)));
    listen_begin_ = now;
  }
  if (now - listen_begin_ < from_seconds(settings_.listen_s)) return Progress::running;
  stage_ = Stage::power;
  return switch_power(bus, now);
}

BusSetup::Progress BusSetup::switch_power(BusMaster& bus, Nanoseconds now) {
  if (!settings_.require_opencr) {
    stage_ = Stage::find;
    return Progress::running;
  }
  namespace opencr = servo_bus::opencr;
  const Result<std::int64_t> before = bus.read_register(opencr::kId, opencr::kServoPower, 1);
  if (before.status() == Status::io_error) return failed(Fault::bus_gone, opencr::kId);
  if (before.ok() && *before == 1) {  // nothing to switch, nothing that boots
    stage_ = Stage::find;
    next_step();
    return Progress::running;
  }
  if (before.ok() && bus.write_register(opencr::kId, opencr::kServoPower, 1, 1) == Status::ok) {
    const Result<std::int64_t> power = bus.read_register(opencr::kId, opencr::kServoPower, 1);
    if (power.ok() && *power == 1) {
      power_time_ = now;
      stage_ = Stage::wait;
      next_step();
      return Progress::running;
    }
  }
  return unanswered(Fault::power_switch, opencr::kId);
}

BusSetup::Progress BusSetup::find_servo(BusMaster& bus) {
  const std::uint8_t id = kServoIds[static_cast<std::size_t>(slot_)];
  const Result<BusMaster::Identity> identity = bus.ping(id);
  if (identity.status() == Status::io_error) return failed(Fault::bus_gone, id);
  if (!identity.ok()) return unanswered(Fault::servo_missing, id);
  if (identity->model != xm430::kModel) return answered_wrongly(Fault::servo_model, id);
  const Result<std::int64_t> torque = bus.read_register(id, xm430::kTorqueEnable.address, 1);
  if (!torque.ok()) return unanswered(Fault::servo_missing, id);
  torque_on_[static_cast<std::size_t>(slot_)] = *torque != 0;
  torque_found_ = torque_found_ || (*torque != 0 && slot_ < model::kNumJoints);
  all_fast_ = all_fast_ && identity->firmware >= xm430::kFirmwareWithFastRead;
  next_step();
  if (++slot_ < kNumServos) return Progress::running;
  slot_ = 0;
  stage_ = Stage::registers;
  if (++looks_ < kLooks && legs_disagree()) look_again();
  return Progress::running;
}

bool BusSetup::legs_disagree() const {
  const auto legs = std::span(torque_on_).first<model::kNumJoints>();
  return std::ranges::find(legs, true) != legs.end() &&
         std::ranges::find(legs, false) != legs.end();
}

void BusSetup::look_again() {
  stage_ = Stage::find;
  slot_ = 0;
  register_ = 0;
  torque_found_ = false;
  next_step();
}

/// One of two readings of a leg's torque was wrong, and it may hold a robot up: who decides then
/// believes that it does.
BusSetup::Progress BusSetup::found_on_after_all(std::uint8_t id) {
  torque_found_ = looks_ >= kLooks;
  if (torque_found_) return failed(Fault::servo_register, id);
  look_again();
  return Progress::running;
}

BusSetup::Progress BusSetup::set_registers(BusMaster& bus) {
  const std::uint8_t id = kServoIds[static_cast<std::size_t>(slot_)];
  const auto wanted = wanted_registers(settings_);
  const bool on = torque_on_[static_cast<std::size_t>(slot_)];
  Status status = Status::ok;
  if (register_ == 0 && slot_ < model::kNumJoints && !on) {
    const Result<std::int64_t> torque = bus.read_register(id, xm430::kTorqueEnable.address, 1);
    if (torque.ok() && *torque != 0) return found_on_after_all(id);
    status = torque.status();
  } else {
    status = torque_found_ && on ? ensure_alive(bus, id, wanted[register_])
                                 : ensure(bus, id, wanted[register_]);
  }
  if (status == Status::io_error) return failed(Fault::bus_gone, id);
  if (status == Status::timeout) return unanswered(Fault::servo_missing, id);
  if (status != Status::ok) return answered_wrongly(Fault::servo_register, id);
  next_step();
  if (++register_ < wanted.size()) return Progress::running;
  register_ = 0;
  if (++slot_ < kNumServos) return Progress::running;
  slot_ = 0;
  bus.use_fast_read(settings_.fast_sync_read && all_fast_);
  stage_ = torque_found_ ? Stage::goals : Stage::finished;
  return torque_found_ ? Progress::running : Progress::done;
}

BusSetup::Progress BusSetup::read_goals(BusMaster& bus) {
  const std::uint8_t id = kServoIds[static_cast<std::size_t>(slot_)];
  const servo_bus::Register& goal = xm430::kGoalPosition;
  const Result<std::int64_t> raw = bus.read_register(id, goal.address, goal.size, goal.is_signed);
  if (raw.status() == Status::io_error) return failed(Fault::bus_gone, id);
  if (!raw.ok()) return unanswered(Fault::servo_missing, id);
  std::int32_t& known_raw = goals_raw_[static_cast<std::size_t>(slot_)];
  const std::int32_t goal_raw = bus.joint_raw(slot_, static_cast<std::int32_t>(*raw));
  const bool agreed = goal_read_ && goal_raw == known_raw;
  known_raw = goal_raw;
  goal_read_ = true;
  if (!agreed || !can_be_held(slot_, goal_raw)) return unanswered(Fault::servo_register, id);
  goal_read_ = false;
  next_step();
  if (++slot_ < kNumServos) return Progress::running;
  stage_ = Stage::finished;
  for (std::size_t s = 0; s < model::kNumJoints; ++s)
    if (!torque_on_[s]) return failed(Fault::torque_lost, kServoIds[s]);
  return Progress::done;
}

}  // namespace sanso::firmware
