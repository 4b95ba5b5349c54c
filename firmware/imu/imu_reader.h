// The IMU thread's work: switch the sensor on, take its reports, hand the newest complete sample to
// the tick. A sample is complete when acceleration, rate and orientation have all come since the
// last one.
#pragma once

#include "firmware/board/board.h"
#include "firmware/config/settings.h"
#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/samples.h"
#include "firmware/imu/hid_descriptor.h"

namespace sanso::firmware {

class ImuReader {
 public:
  ImuReader(const ImuSettings& settings, board::HidSource& source, board::Clock& clock,
            Mailbox<ImuSample>& out);

  /// Takes every report there is; waits for the first until `deadline`.
  void poll(Nanoseconds deadline);

  /// ok once the descriptor was understood and the sensor switched on.
  Status status() const { return status_; }
  std::uint32_t bad_reports() const { return bad_reports_; }

 private:
  void start();
  void take(std::span<const std::uint8_t> report);
  void complete();

  ImuSettings settings_;
  board::HidSource& source_;
  board::Clock& clock_;
  Mailbox<ImuSample>& out_;
  HidLayout layout_;
  Status status_ = Status::not_ready;
  math::Quat quat_base_sensor_;

  math::Vec3 accel_ = math::Vec3::Zero(), gyro_ = math::Vec3::Zero();  // sensor axes
  math::Quat quat_world_sensor_ = math::quat_identity();
  unsigned have_ = 0;  // bit per quantity since the last complete sample
  ImuSample sample_;
  std::uint32_t bad_reports_ = 0;
};

}  // namespace sanso::firmware
