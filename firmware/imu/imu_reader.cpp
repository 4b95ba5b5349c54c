// Switches a sensor on by reading, changing and writing its feature reports; collects fields until
// the sample is complete.
#include "firmware/imu/imu_reader.h"

#include <cmath>

namespace sanso::firmware {
namespace {
constexpr int kMaxReportsAtOnce = 64;
constexpr unsigned bit_of(HidQuantity quantity) { return 1u << static_cast<unsigned>(quantity); }
}  // namespace

void ImuReader::start() {
  const board::Bytes descriptor = source_.descriptor();
  if (descriptor.empty()) {
    status_ = Status::not_ready;
    return;
  }
  status_ = parse_hid_descriptor(descriptor, layout_, source_.identity());
  if (status_ != Status::ok) return source_.reject();  // a keyboard, say
  wanted_ = bit_of(HidQuantity::acceleration) | bit_of(HidQuantity::angular_velocity);
  if (layout_.has(HidQuantity::quaternion)) wanted_ |= bit_of(HidQuantity::quaternion);
  have_ = 0;
  for (const HidFeature& feature : layout_.features)
    if (switch_on(feature) != Status::ok) ++refused_features_;
}

/// Only our fields change: the rest of the report goes back as the device has it.
Status ImuReader::switch_on(const HidFeature& feature) {
  const auto interval_ms = static_cast<unsigned>(std::lround(settings_.period_s * 1e3));
  std::array<std::uint8_t, 64> report{};
  report[0] = feature.report_id;
  if (feature.bytes <= report.size() &&
      !source_.get_feature(std::span(report).first(feature.bytes)).ok())
    report.fill(0);
  const std::size_t bytes = make_feature_report(feature, interval_ms, report);
  return bytes == 0 ? Status::full : source_.set_feature(std::span(report).first(bytes));
}

Status ImuReader::poll(Nanoseconds deadline) {
  if (status_ != Status::ok) start();
  if (status_ != Status::ok) return status_;
  std::array<std::uint8_t, 256> report;
  for (int i = 0; i < kMaxReportsAtOnce; ++i) {
    const Result<std::size_t> n = source_.read(report, i == 0 ? deadline : 0);
    if (!n.ok()) {
      status_ = n.status();  // unplugged: start again with the next poll
      return status_;
    }
    if (*n == 0) break;
    take(std::span(report).first(*n));
  }
  return Status::ok;
}

void ImuReader::take(std::span<const std::uint8_t> report) {
  bool known = false, whole = true;
  for (const HidField& field : layout_.fields) {
    if (field.report_id != 0 && field.report_id != report[0]) continue;
    known = true;
    std::array<double, 4> v{};
    for (int e = 0; e < field.count; ++e)
      whole = whole && read_hid_field(field, e, report, v[static_cast<std::size_t>(e)]);
    if (!whole) break;
    switch (field.quantity) {
      case HidQuantity::acceleration:
        accel_[field.component] = v[0];
        break;
      case HidQuantity::angular_velocity:
        gyro_[field.component] = v[0];
        break;
      case HidQuantity::quaternion: {
        const math::Quat q(v[3], v[0], v[1], v[2]);  // HID order is x y z w
        whole = std::abs(q.norm() - 1.0) < 0.05;
        if (whole) quat_world_sensor_ = math::quat_normalized(q);
        break;
      }
    }
    if (whole) have_ |= bit_of(field.quantity);
  }
  if (!known || !whole) return;
  if ((have_ & wanted_) != wanted_) return;
  have_ = 0;
  const bool oriented = (wanted_ & bit_of(HidQuantity::quaternion)) != 0;
  assembler_.publish(clock_.now(), gyro_, accel_,
                     oriented ? std::optional(quat_world_sensor_) : std::nullopt);
}

}  // namespace sanso::firmware
