// Start-up of the bus, one small step a tick: listen, supply on, every servo there and an XM430,
// registers as the controller needs them and read back. What the servos are doing is read before
// anything is written: a robot that is found standing keeps its torque, its goals and its EEPROM,
// and the controller adopts it. No single answer decides: a leg's torque is never switched off
// here, and what contradicts itself is asked again. A servo's EEPROM is never written: what differs
// there is a fault that names the servo, and the owner's self-test writes it when told to.
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

  /// Every servo has been heard: feedback can be read.
  bool servos_heard() const { return stage_ == Stage::registers && slot_ == kNumServos - 1; }
  bool finished() const { return stage_ == Stage::finished; }
  /// At least one leg servo was found with torque on: somebody may stand on it.
  bool torque_found() const { return torque_found_; }
  /// Goals that the servos were found with [raw]; filled when torque was found and step() is done.
  const std::array<std::int32_t, kNumServos>& goals_raw() const { return goals_raw_; }

  Fault fault() const { return fault_; }
  /// Servo id (or 200, the OpenCR board) that failed.
  std::uint16_t fault_detail() const { return detail_; }

 private:
  enum class Stage : std::uint8_t { listen, power, wait, find, registers, goals, finished };
  Progress listen(BusMaster& bus, Nanoseconds now);
  Progress switch_power(BusMaster& bus, Nanoseconds now);
  Progress find_servo(BusMaster& bus);
  Progress set_registers(BusMaster& bus);
  Progress read_goals(BusMaster& bus);
  void look_again();
  Progress found_on_after_all(std::uint8_t id);
  bool legs_disagree() const;
  Progress answered_wrongly(Fault fault, std::uint8_t id);
  Progress unanswered(Fault fault, std::uint8_t id);
  void next_step() { silences_ = wrongs_ = 0; }
  Progress failed(Fault fault, std::uint16_t detail);

  BusSettings settings_;
  Stage stage_ = Stage::listen;
  Nanoseconds listen_begin_ = 0;
  int noise_bytes_ = 0;            // heard while listening
  int silences_ = 0, wrongs_ = 0;  // of this step so far
  int looks_ = 0;                  // times that the torque of all servos was looked at
  int slot_ = 0;
  std::size_t register_ = 0;
  bool all_fast_ = true;
  Nanoseconds power_time_ = 0;
  std::array<bool, kNumServos> torque_on_{};
  bool torque_found_ = false;
  std::array<std::int32_t, kNumServos> goals_raw_{};
  bool goal_read_ = false;  // goals_raw_[slot_] holds one reading; the next has to agree
  Fault fault_ = Fault::none;
  std::uint16_t detail_ = 0;
};

}  // namespace sanso::firmware
