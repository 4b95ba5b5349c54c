// A state machine of one bus transaction a call; registers are read, written only when
// different, and read back.
#include "firmware/bus/bus_setup.h"

#include <array>

#include "shared/servo_bus/opencr.h"

namespace sanso::firmware {
namespace {

namespace xm430 = servo_bus::xm430;
constexpr int kTries = 5;  // a register that answers with something else
// silence, 2 s: lost replies and a servo that takes its time to boot must not stop the start-up
constexpr int kFindTries = 200;

struct Wanted {
  const servo_bus::Register& reg;
  std::int64_t value;
};

/// In this order: torque off first (EEPROM), mode before gains (a mode change resets them).
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

/// Makes a register hold `value`: reads, writes only when it differs, reads back.
Status ensure(BusMaster& bus, std::uint8_t id, const Wanted& wanted) {
  const servo_bus::Register& r = wanted.reg;
  Result<std::int64_t> value = bus.read_register(id, r.address, r.size, r.is_signed);
  if (!value.ok()) return value.status();
  if (*value == wanted.value) return Status::ok;
  if (const Status status = bus.write_register(id, r.address, r.size, wanted.value);
      status != Status::ok)
    return status;
  value = bus.read_register(id, r.address, r.size, r.is_signed);
  if (!value.ok()) return value.status();
  return *value == wanted.value ? Status::ok : Status::rejected;
}

}  // namespace

BusSetup::Progress BusSetup::failed(Fault fault, std::uint8_t id) {
  fault_ = fault;
  detail_ = id;
  return Progress::failed;
}

BusSetup::Progress BusSetup::step(BusMaster& bus, Nanoseconds now) {
  switch (stage_) {
    case Stage::power:
      return switch_power(bus, now);
    case Stage::wait:
      if (now - power_time_ >= from_seconds(settings_.power_up_wait_s)) stage_ = Stage::find;
      return Progress::running;
    case Stage::find:
      return find_servo(bus);
    case Stage::registers:
      return set_registers(bus);
    case Stage::finish:
      return Progress::done;
  }
  return Progress::done;
}

BusSetup::Progress BusSetup::switch_power(BusMaster& bus, Nanoseconds now) {
  if (!settings_.require_opencr) {
    stage_ = Stage::find;
    return Progress::running;
  }
  namespace opencr = servo_bus::opencr;
  const Status status = bus.write_register(opencr::kId, opencr::kServoPower, 1, 1);
  if (status == Status::io_error) return failed(Fault::bus_gone, opencr::kId);
  if (status == Status::ok) {
    const Result<std::int64_t> power = bus.read_register(opencr::kId, opencr::kServoPower, 1);
    if (power.ok() && *power == 1) {
      power_time_ = now;
      stage_ = Stage::wait;
      tries_ = 0;
      return Progress::running;
    }
  }
  return ++tries_ < kFindTries ? Progress::running : failed(Fault::power_switch, opencr::kId);
}

BusSetup::Progress BusSetup::find_servo(BusMaster& bus) {
  const std::uint8_t id = kServoIds[static_cast<std::size_t>(slot_)];
  const Result<BusMaster::Identity> identity = bus.ping(id);
  if (!identity.ok())
    return ++tries_ < kFindTries ? Progress::running : failed(Fault::servo_missing, id);
  if (identity->model != xm430::kModel) return failed(Fault::servo_model, id);
  all_fast_ = all_fast_ && identity->firmware >= xm430::kFirmwareWithFastRead;
  tries_ = 0;
  if (++slot_ == kNumServos) {
    slot_ = 0;
    stage_ = Stage::registers;
  }
  return Progress::running;
}

BusSetup::Progress BusSetup::set_registers(BusMaster& bus) {
  const std::uint8_t id = kServoIds[static_cast<std::size_t>(slot_)];
  const auto wanted = wanted_registers(settings_);
  const Status status = ensure(bus, id, wanted[register_]);
  if (status == Status::timeout)
    return ++tries_ < kFindTries ? Progress::running : failed(Fault::servo_missing, id);
  if (status != Status::ok)
    return ++tries_ < kTries ? Progress::running : failed(Fault::servo_register, id);
  tries_ = 0;
  if (++register_ < wanted.size()) return Progress::running;
  register_ = 0;
  if (++slot_ < kNumServos) return Progress::running;
  bus.use_fast_read(settings_.fast_sync_read && all_fast_);
  stage_ = Stage::finish;
  return Progress::done;
}

}  // namespace sanso::firmware
