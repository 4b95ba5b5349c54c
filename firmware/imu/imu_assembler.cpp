// Mounting first, then everything else in base axes; change is judged by what the sensor sent.
#include "firmware/imu/imu_assembler.h"

#include <algorithm>

namespace sanso::firmware {

ImuAssembler::ImuAssembler(const ImuSettings& settings, Mailbox<ImuSample>& out)
    : out_(out), remove_bias_(settings.gyro_bias_at_rest) {
  quat_base_sensor_ =
      math::quat_normalized({settings.quat_base_sensor_w, settings.quat_base_sensor_x,
                             settings.quat_base_sensor_y, settings.quat_base_sensor_z});
}

void ImuAssembler::publish(Nanoseconds now, const math::Vec3& gyro, const math::Vec3& accel,
                           const std::optional<math::Quat>& quat_world_sensor) {
  // as the sensor sent it: what is estimated from frozen readings would go on changing
  const bool changed = sample_.sequence == 0 || gyro != raw_gyro_ || accel != raw_accel_ ||
                       (quat_world_sensor && raw_quat_ && *quat_world_sensor != *raw_quat_);
  raw_gyro_ = gyro;
  raw_accel_ = accel;
  raw_quat_ = quat_world_sensor;

  const math::Mat3 R_base_sensor = math::rotation_matrix(quat_base_sensor_);
  const math::Vec3 gyro_base = R_base_sensor * gyro, accel_base = R_base_sensor * accel;
  const double dt = sample_.time == 0 ? 0.0 : std::clamp(to_seconds(now - sample_.time), 0.0, 0.1);
  const bool estimate = !quat_world_sensor.has_value();
  if (estimate || remove_bias_) filter_.update(gyro_base, accel_base, dt);
  sample_.time = now;
  ++sample_.sequence;
  if (changed) ++sample_.changes;
  sample_.gyro = estimate || remove_bias_ ? math::Vec3(gyro_base - filter_.bias()) : gyro_base;
  sample_.accel = accel_base;
  sample_.quat_world_base =
      estimate ? filter_.quat_world_body()
               : math::quat_multiply(*quat_world_sensor, math::quat_conjugate(quat_base_sensor_));
  out_.back() = sample_;
  out_.publish();
}

}  // namespace sanso::firmware
