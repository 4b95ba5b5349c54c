// The IMU as a HID sensor: three sensors in one device, input reports 1 (accelerometer), 2 (gyro),
// 3 (orientation), feature reports that switch them on. Bytes as in docs/howto/emulator.md; the
// descriptor says the same.
#pragma once

#include <array>
#include <deque>
#include <span>
#include <vector>

#include "shared/base/time.h"
#include "tools/plant/random.h"
#include "tools/plant/world.h"

namespace sanso::emulator {

/// What the IMU feels, base axes.
struct ImuTruth {
  plant::Vec3 specific_force{};  // m/s^2; +9.81 along the upward axis at rest
  plant::Vec3 rate{};            // rad/s
  plant::Quat quat_world_base{1, 0, 0, 0};
};

class HidImu {
 public:
  HidImu(const plant::ImuParameters& parameters, std::uint64_t seed);

  /// Called every millisecond: one report slot of the USB endpoint. `silent` and `frozen` are the
  /// fault switches.
  void update(Nanoseconds now, const ImuTruth& truth, bool silent, bool frozen);

  /// The oldest input report that waits; 0: none.
  std::size_t read(std::span<std::uint8_t> out);
  /// A feature report, its ID first; false: the sensor refuses it.
  bool set_feature(std::span<const std::uint8_t> report);
  /// Bytes of the feature report, its ID first; 0: there is none of this ID.
  std::size_t get_feature(std::uint8_t report_id, std::span<std::uint8_t> out) const;
  /// The report descriptor, as the sensor sends it.
  static std::span<const std::uint8_t> descriptor();

 private:
  struct Sensor {
    std::uint8_t reporting = 0;  // index: 0 no events, 1 all events
    std::uint8_t power = 0;      // index: 1 = D0, full power
    std::uint32_t interval_ms = 10;
    Nanoseconds next = 0;
    bool active() const { return reporting == 1 && power == 1; }
  };
  using Report = std::vector<std::uint8_t>;
  Report make_report(int sensor, const ImuTruth& truth);
  void drift(const ImuTruth& truth);
  plant::Vec3 noisy(const plant::Vec3& value, const plant::Vec3& bias, double deviation);

  plant::ImuParameters parameters_;
  plant::Random random_;
  plant::Vec3 error_{};  // rotation vector, base axes, rad
  double heading_error_ = 0.0;
  std::array<Sensor, 3> sensors_;
  std::array<Report, 3> last_;
  std::deque<Report> due_;    // sampled, waiting for a slot of the endpoint
  std::deque<Report> ready_;  // delivered
};

}  // namespace sanso::emulator
