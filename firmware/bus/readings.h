// What the bus has told about the servos, by slot (servos.h).
#pragma once

#include <array>
#include <cstdint>

#include "firmware/bus/servos.h"

namespace sanso::firmware {

struct ServoReading {
  double position_rad = 0;
  double velocity_rad_s = 0;
  std::int32_t position_raw = 0;
  std::int16_t current_raw = 0;
  bool known = false;           // has answered since boot
  std::uint16_t age_ticks = 0;  // cyclic reads since its last good answer, 0: this tick's
  bool alert = false;           // hardware error bit of its last status
};

/// From the slow round: one servo every few ticks.
struct ServoHealth {
  float voltage_V = 0;             // 0: not yet read
  float temperature_C = 0;         // 0: not yet read
  std::uint32_t supply_reads = 0;  // counts readings of the two above
  std::uint8_t hardware_error = 0;
  bool torque_known = false;  // torque_on was read since torque was last switched
  bool torque_on = false;
};

struct ServoReadings {
  std::array<ServoReading, kNumServos> servo{};
  std::array<ServoHealth, kNumServos> health{};
  int asked = 0;     // servos asked this tick
  int answered = 0;  // of them, with a good reply
  bool port_gone = false;
};

/// What the OpenCR board shows beside the servos.
struct BoardReading {
  std::uint8_t buttons = 0;  // bits of servo_bus::opencr::kButton*
  double voltage_V = 0;
  std::array<std::int16_t, 3> gyro_raw{}, accel_raw{};  // the board's own axes
};

struct BusCounters {
  std::uint32_t lost = 0;     // replies missing at the deadline
  std::uint32_t corrupt = 0;  // replies that arrived damaged
  std::uint32_t noise_bytes = 0;
  std::uint32_t implausible = 0;  // whole replies whose contents cannot be: error, jump, range
  std::uint32_t unsent = 0;       // requests that the port did not take
  std::uint32_t foreign = 0;      // instructions of another master
  std::array<std::uint32_t, kNumServos> lost_by_servo{};
};

}  // namespace sanso::firmware
