// Requests to one device: one slow read a tick in turn, registers one by one, the board.
#include <array>
#include <cstdint>

#include "firmware/bus/bus_master.h"
#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/units.h"

namespace sanso::firmware {
namespace bus = servo_bus;
namespace {

constexpr std::uint16_t kSupplyAddress = 144, kSupplyBytes = 3;  // voltage u16, temperature u8
// torque enable .. hardware error status
constexpr std::uint16_t kTorqueAddress = 64, kTorqueBytes = 7;

}  // namespace

// --- slow reads ----------------------------------------------------------------------------------

void BusMaster::slow_read_supply(int slot, ServoReadings& readings) {
  const std::uint8_t id = kServoIds[static_cast<std::size_t>(slot)];
  (void)bus::encode_read(request_, id, kSupplyAddress, kSupplyBytes);
  if (transact(id) != Status::ok || packet_.parameters.size() != kSupplyBytes) return;
  ServoHealth& health = readings.health[static_cast<std::size_t>(slot)];
  health.voltage_V = static_cast<float>(bus::voltage_V(bus::get_u16(packet_.parameters.view())));
  health.temperature_C = packet_.parameters[2];
  ++health.supply_reads;
}

void BusMaster::slow_read_torque(int slot, ServoReadings& readings) {
  const std::uint8_t id = kServoIds[static_cast<std::size_t>(slot)];
  (void)bus::encode_read(request_, id, kTorqueAddress, kTorqueBytes);
  if (transact(id) != Status::ok || packet_.parameters.size() != kTorqueBytes) return;
  ServoHealth& health = readings.health[static_cast<std::size_t>(slot)];
  health.torque_on = packet_.parameters[0] != 0;
  health.torque_known = true;
  health.hardware_error = packet_.parameters[6];
  if (health.hardware_error == 0) readings.servo[static_cast<std::size_t>(slot)].alert = false;
}

void BusMaster::slow_read(ServoReadings& readings) {
  // An alert that nobody has explained yet goes first, but not twice in a row: a servo that says
  // alert and then nothing more must not keep the others from being asked.
  alert_turn_ = !alert_turn_;
  for (int s = 0; s < kNumServos && alert_turn_; ++s) {
    const bool explained = readings.health[static_cast<std::size_t>(s)].hardware_error != 0;
    if (readings.servo[static_cast<std::size_t>(s)].alert && !explained)
      return slow_read_torque(s, readings);
  }
  alert_turn_ = false;
  const int slot = slow_turn_ / 2;
  if (slow_turn_ % 2 == 0)
    slow_read_supply(slot, readings);
  else
    slow_read_torque(slot, readings);
  slow_turn_ = (slow_turn_ + 1) % (2 * kNumServos);
}

// --- single transactions -------------------------------------------------------------------------

Result<BusMaster::Identity> BusMaster::ping(std::uint8_t id) {
  (void)bus::encode_ping(request_, id);
  if (const Status status = transact(id); status != Status::ok) return status;
  if (packet_.parameters.size() != 3) return Status::malformed;
  return Identity{bus::get_u16(packet_.parameters.view()), packet_.parameters[2]};
}

Result<std::int64_t> BusMaster::read_register(std::uint8_t id, std::uint16_t address,
                                              std::uint8_t size, bool is_signed) {
  (void)bus::encode_read(request_, id, address, size);
  if (const Status status = transact(id); status != Status::ok) return status;
  if (packet_.status_error() != bus::StatusError::none || size == 0 ||
      packet_.parameters.size() != size)
    return Status::rejected;
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = (value << 8) | packet_.parameters[i];
  const std::uint64_t sign = std::uint64_t{1} << (8 * size - 1);
  if (is_signed && (value & sign) != 0)
    return static_cast<std::int64_t>(value) - static_cast<std::int64_t>(sign << 1);
  return static_cast<std::int64_t>(value);
}

Status BusMaster::write_register(std::uint8_t id, std::uint16_t address, std::uint8_t size,
                                 std::int64_t value) {
  std::array<std::uint8_t, 4> data{};
  bus::put_le(data.data(), size, value);
  (void)bus::encode_write(request_, id, address, std::span(data).first(size));
  if (const Status status = transact(id); status != Status::ok) return status;
  return packet_.status_error() == bus::StatusError::none ? Status::ok : Status::rejected;
}

Result<BoardReading> BusMaster::read_board() {
  namespace opencr = bus::opencr;
  constexpr std::uint16_t kFirst = opencr::kButtons, kBytes = opencr::kRollPitchYaw - kFirst;
  (void)bus::encode_read(request_, opencr::kId, kFirst, kBytes);
  if (const Status status = transact(opencr::kId); status != Status::ok) return status;
  if (packet_.status_error() != bus::StatusError::none || packet_.parameters.size() != kBytes)
    return Status::rejected;
  const auto data = packet_.parameters.view();
  BoardReading reading;
  reading.buttons = data[0];
  reading.voltage_V = 0.1 * data[opencr::kVoltage - kFirst];
  for (std::size_t a = 0; a < 3; ++a) {
    reading.gyro_raw[a] = bus::get_i16(data.subspan(opencr::kGyro - kFirst + 2 * a));
    reading.accel_raw[a] = bus::get_i16(data.subspan(opencr::kAccelerometer - kFirst + 2 * a));
  }
  return reading;
}

Status BusMaster::reboot(std::uint8_t id) {
  (void)bus::encode_reboot(request_, id);
  return transact(id);
}

}  // namespace sanso::firmware
