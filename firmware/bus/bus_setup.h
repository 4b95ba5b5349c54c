// Start-up of the bus, one small step a tick: supply on, every servo there and an XM430, torque
// off, registers as the controller needs them and read back. Leaves a servo's EEPROM alone when it
// already holds what is needed.
#pragma once

#include "firmware/bus/bus_master.h"
#include "firmware/exchange/faults.h"

namespace sanso::firmware {

class BusSetup {
 public:
  enum class Progress : std::uint8_t { running, done, failed };

  explicit BusSetup(const BusSettings& settings) : settings_(settings) {}
  void restart() { *this = BusSetup(settings_); }
  /// One step; at most three short transactions.
  Progress step(BusMaster& bus, Nanoseconds now);

  Fault fault() const { return fault_; }
  /// Servo id (or 200, the OpenCR board) that failed.
  std::uint16_t fault_detail() const { return detail_; }

 private:
  enum class Stage : std::uint8_t { power, wait, find, registers, finish };
  Progress switch_power(BusMaster& bus, Nanoseconds now);
  Progress find_servo(BusMaster& bus);
  Progress set_registers(BusMaster& bus);
  Progress failed(Fault fault, std::uint8_t id);

  BusSettings settings_;
  Stage stage_ = Stage::power;
  int tries_ = 0;
  int slot_ = 0;
  std::size_t register_ = 0;
  bool all_fast_ = true;
  Nanoseconds power_time_ = 0;
  Fault fault_ = Fault::none;
  std::uint16_t detail_ = 0;
};

}  // namespace sanso::firmware
