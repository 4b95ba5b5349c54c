// Samples wait for their delay before they can be read; a lost tracker reports confidence 0.
#include "tools/emulator/pose_source.h"

#include <algorithm>
#include <cmath>

namespace sanso::emulator {

/// A random walk: its deviation grows with the root of time.
void PoseSource::drift() {
  if (parameters_.drift_m == 0.0) return;
  for (double& axis : drift_)
    axis += parameters_.drift_m * std::sqrt(parameters_.period_s) * random_.normal();
}

void PoseSource::update(Nanoseconds now, const plant::BaseMotion& base, bool lost) {
  if (now < next_) return;
  next_ = now + from_seconds(parameters_.period_s);
  drift();
  if (parameters_.dropouts_per_s > 0.0 &&
      random_.chance(parameters_.dropouts_per_s * parameters_.period_s))
    back_ = now + from_seconds(parameters_.dropout_s);
  PoseReport report;
  report.confidence = lost || now < back_ ? 0 : 3;
  report.sequence = sequence_++;
  report.age_us = static_cast<std::uint32_t>(from_seconds(parameters_.delay_s) / kMicrosecond);
  plant::Vec3 tilt;
  for (double& component : tilt) component = parameters_.orientation_noise_rad * random_.normal();
  const auto q = plant::multiply(base.quat_world_base, plant::from_rotation_vector(tilt));
  for (std::size_t i = 0; i < 4; ++i) report.quat_world_base[i] = static_cast<float>(q[i]);
  for (std::size_t i = 0; i < 3; ++i) {
    report.p_world_base[i] = static_cast<float>(base.p_world_base[i] + drift_[i] +
                                                parameters_.position_noise_m * random_.normal());
    report.v_base_in_world[i] = static_cast<float>(
        base.v_base_in_world[i] + parameters_.velocity_noise_m_s * random_.normal());
  }
  samples_.push_back({now + from_seconds(parameters_.delay_s), report});
  constexpr std::size_t kQueueLimit = 64;
  while (samples_.size() > kQueueLimit) samples_.pop_front();
}

std::size_t PoseSource::read(std::span<std::uint8_t> out, Nanoseconds now) {
  if (samples_.empty() || samples_.front().due > now || out.size() < kPoseReportBytes) return 0;
  const auto bytes = encode_pose_report(samples_.front().report);
  samples_.pop_front();
  std::copy(bytes.begin(), bytes.end(), out.begin());
  return bytes.size();
}

}  // namespace sanso::emulator
