// Switching the torque on so that nothing moves: goals are where the joints are, and both goals and
// torque are read back from every servo before the next step. A lost or damaged packet costs a
// tick; what stays unconfirmed ends in a refusal with torque off.
#pragma once

#include <array>

#include "firmware/bus/bus_master.h"
#include "firmware/exchange/faults.h"

namespace sanso::firmware {

class Arming {
 public:
  enum class Progress : std::uint8_t { busy, done, failed };
  using Duties = std::array<std::int32_t, kNumServos>;

  /// The gate is open: from the next step() on.
  void begin();
  void cancel() { stage_ = Stage::none; }
  bool active() const { return stage_ != Stage::none; }
  /// Torque may be on at some servo.
  bool torque_written() const { return torque_written_; }

  /// One tick on the bus, after the cyclic read. `duties_raw`: Goal PWM of each servo.
  Progress step(BusMaster& bus, ServoReadings& servos, const Duties& duties_raw);
  /// Why it failed.
  Refusal refusal() const { return refusal_; }
  /// Goals that the servos hold, by slot [raw].
  const std::array<std::int32_t, kNumServos>& goals_raw() const { return goals_raw_; }

 private:
  enum class Stage : std::uint8_t { none, goals, torque, settle };
  Progress write_goals(BusMaster& bus, const ServoReadings& servos, const Duties& duties_raw);
  Progress write_torque(BusMaster& bus, ServoReadings& servos);
  bool moved(const ServoReadings& servos) const;
  Progress again(Refusal why);

  Stage stage_ = Stage::none;
  int tries_ = 0;
  bool torque_written_ = false;
  Refusal refusal_ = Refusal::none;
  std::array<std::int32_t, kNumServos> goals_raw_{};
  ServoBlocks blocks_;
};

}  // namespace sanso::firmware
