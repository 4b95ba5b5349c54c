// The guard between the sum of the layers and the servos, and the watch over what they report.
// limit() makes any target safe to send and says what it had to change; watch() says whether the
// robot may go on at all.
#pragma once

#include "firmware/bus/readings.h"
#include "firmware/config/settings.h"
#include "firmware/exchange/faults.h"
#include "firmware/exchange/samples.h"
#include "shared/model/state_layout.h"

namespace sanso::firmware {

struct GuardVerdict {
  Fault fault = Fault::none;
  std::uint16_t detail = 0;  // servo id, or what docs/faults.md says for the fault
  LimitSet limits;
};

/// What the guard needs to know besides sensor values.
struct GuardSituation {
  Nanoseconds now = 0;
  bool torque_expected = false;  // torque was switched on long enough ago
  bool standing = false;         // a fall would be a fall: on in stand-up, hold, run, soft-stop
  double tilt = 0;               // rad
  double height = 0;             // base above the lower sole, m
  bool estimate_healthy = true;
  int late_in_a_row = 0;
};

class Guard {
 public:
  Guard(const GuardSettings& guard, const BusSettings& bus, const ImuSettings& imu)
      : settings_(guard), bus_(bus), imu_(imu) {}

  /// The worst fault of this tick, and the limits that the readings touch.
  GuardVerdict watch(const GuardSituation& situation, const ServoReadings& servos,
                     const ImuSample& imu);

  /// `wanted` made safe: finite, inside the joint limits, no faster than allowed from `previous`,
  /// no farther from the joint `q` than allowed. Adds what it changed to `limits`.
  model::Input limit(const model::Input& wanted, const model::Input& previous,
                     const model::Input& q, LimitSet& limits) const;

  /// Forgets time counters (after a fault was cleared).
  void reset();

 private:
  void watch_bus(const ServoReadings& servos, GuardVerdict& verdict) const;
  void watch_servos(const GuardSituation& s, const ServoReadings& servos, GuardVerdict& verdict);
  void watch_supply(const ServoReadings& servos, GuardVerdict& verdict);
  void watch_imu(const GuardSituation& s, const ImuSample& imu, GuardVerdict& verdict);
  void watch_body(const GuardSituation& s, GuardVerdict& verdict);

  GuardSettings settings_;
  BusSettings bus_;
  ImuSettings imu_;
  int fall_ticks_ = 0;
  int low_voltage_ticks_ = 0, high_voltage_ticks_ = 0;
  std::uint32_t imu_changes_ = 0;
  Nanoseconds imu_changed_ = 0;
};

}  // namespace sanso::firmware
