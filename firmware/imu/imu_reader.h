// The IMU thread's work: switch the sensor on, take its reports, hand the newest complete sample to
// the tick. A sample is complete when acceleration, rate and (of a sensor that has it) orientation
// have all come since the last one.
#pragma once

#include "firmware/board/board.h"
#include "firmware/imu/hid_descriptor.h"
#include "firmware/imu/imu_assembler.h"

namespace sanso::firmware {

class ImuReader {
 public:
  ImuReader(const ImuSettings& settings, board::HidSource& source, board::Clock& clock,
            Mailbox<ImuSample>& out)
      : settings_(settings), source_(source), clock_(clock), assembler_(settings, out) {}

  /// Takes every report there is; waits for the first until `deadline`. Anything but ok: no sensor
  /// that can be used, and the call came back at once; the caller waits before the next.
  Status poll(Nanoseconds deadline);

  /// ok once the descriptor was understood and the sensor asked to report.
  Status status() const { return status_; }
  /// Switches that the sensor refused; it may report all the same.
  std::uint32_t refused_features() const { return refused_features_; }

 private:
  void start();
  Status switch_on(const HidFeature& feature);
  void take(std::span<const std::uint8_t> report);

  ImuSettings settings_;
  board::HidSource& source_;
  board::Clock& clock_;
  ImuAssembler assembler_;
  HidLayout layout_;
  Status status_ = Status::not_ready;

  math::Vec3 accel_ = math::Vec3::Zero(), gyro_ = math::Vec3::Zero();  // sensor axes
  math::Quat quat_world_sensor_ = math::quat_identity();
  unsigned wanted_ = 0;  // bit per quantity that a complete sample needs
  unsigned have_ = 0;    // bit per quantity since the last complete sample
  std::uint32_t refused_features_ = 0;
};

}  // namespace sanso::firmware
