// The guard between the sum of the layers and the servos, and the watch over what they report.
// limit() makes any target safe to send and says what it had to change; watch() says whether the
// robot may go on at all.
#pragma once

#include <bitset>

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
  bool fallen = false;      // whatever fault came first
  bool must_lower = false;  // a fault whose reaction is to lower, whatever fault came first
};

/// What the guard needs to know besides sensor values.
struct GuardSituation {
  Nanoseconds now = 0;
  bool torque_expected = false;  // torque was switched on long enough ago
  bool standing = false;         // a fall would be a fall: torque is on
  bool watch_held = false;       // arms and head are asked at every tick
  double tilt = 0;               // rad
  double height = 0;             // base above the lower sole, m
  bool estimate_healthy = true;
  bool late = false;            // this tick began late
  bool bus_foreign = false;     // somebody else gives instructions on the bus
  std::uint8_t imu_reason = 0;  // what ImuWatch found, 0: nothing
};

class Guard {
 public:
  Guard(const GuardSettings& guard, const BusSettings& bus, const ImuSettings& imu)
      : settings_(guard), bus_(bus), imu_(imu) {}

  /// The worst fault of this tick, and the limits that the readings touch.
  GuardVerdict watch(const GuardSituation& situation, const ServoReadings& servos,
                     const ImuSample& imu);

  /// `wanted` made safe: finite, no farther from the joint `q` than allowed, inside the joint
  /// limits, and above all no faster than allowed from `previous`: a joint outside its range is
  /// brought in slowly. Adds what it changed to `limits`.
  model::Input limit(const model::Input& wanted, const model::Input& previous,
                     const model::Input& q, LimitSet& limits) const;
  /// The same for arms and head, range and rate.
  std::array<double, kNumHeld> limit_held(const std::array<double, kNumHeld>& wanted,
                                          const std::array<double, kNumHeld>& previous,
                                          LimitSet& limits) const;
  /// Share of the supply voltage that a servo of this temperature may use.
  double allowed_duty(double temperature_C) const;

  /// Forgets time counters (after a fault was cleared).
  void reset();

 private:
  void watch_bus(const GuardSituation& s, const ServoReadings& servos, GuardVerdict& verdict) const;
  void watch_servos(const GuardSituation& s, const ServoReadings& servos, GuardVerdict& verdict);
  void watch_supply(Nanoseconds now, const ServoReadings& servos, GuardVerdict& verdict);
  void watch_lateness(bool late, GuardVerdict& verdict);
  void watch_imu(const GuardSituation& s, const ImuSample& imu, GuardVerdict& verdict);
  void watch_body(const GuardSituation& s, GuardVerdict& verdict);

  GuardSettings settings_;
  BusSettings bus_;
  ImuSettings imu_;
  int fall_ticks_ = 0;
  // since when every new reading of the supply was outside; 0: the last one was not
  Nanoseconds low_since_ = 0, high_since_ = 0;
  std::array<std::uint32_t, kNumServos> seen_reads_{};
  std::bitset<100> late_;  // of the last ticks
  std::size_t late_next_ = 0;
  std::uint32_t imu_changes_ = 0;
  Nanoseconds imu_changed_ = 0;
};

}  // namespace sanso::firmware
