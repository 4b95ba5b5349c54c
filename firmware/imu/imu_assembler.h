// From a sensor's numbers to the sample that the tick uses: mounting, orientation for sensors that
// give none, gyro bias, and the counters by which a frozen sensor is known. Shared by all IMU
// sources. Real-time safe.
#pragma once

#include <optional>

#include "firmware/config/settings.h"
#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/samples.h"
#include "firmware/imu/orientation_filter.h"

namespace sanso::firmware {

class ImuAssembler {
 public:
  ImuAssembler(const ImuSettings& settings, Mailbox<ImuSample>& out);

  /// A complete set of readings in sensor axes: rate [rad/s], specific force [m/s^2] and, when the
  /// sensor knows it, its orientation. Publishes a sample.
  void publish(Nanoseconds now, const math::Vec3& gyro, const math::Vec3& accel,
               const std::optional<math::Quat>& quat_world_sensor);

 private:
  Mailbox<ImuSample>& out_;
  math::Quat quat_base_sensor_;
  bool remove_bias_;
  OrientationFilter filter_;  // base axes
  math::Vec3 raw_gyro_ = math::Vec3::Zero(), raw_accel_ = math::Vec3::Zero();
  std::optional<math::Quat> raw_quat_;
  ImuSample sample_;
};

}  // namespace sanso::firmware
