// Reads until the deadline, converts counts into m/s^2, rad/s and a quaternion of the base, and
// publishes when all three have come.
#include "firmware/imu/imu_reader.h"

#include <cmath>

namespace sanso::firmware {
namespace {
constexpr unsigned kAllQuantities = 7u;
constexpr int kMaxReportsAtOnce = 64;
}  // namespace

ImuReader::ImuReader(const ImuSettings& settings, board::HidSource& source, board::Clock& clock,
                     Mailbox<ImuSample>& out)
    : settings_(settings), source_(source), clock_(clock), out_(out) {
  quat_base_sensor_ =
      math::quat_normalized({settings.quat_base_sensor_w, settings.quat_base_sensor_x,
                             settings.quat_base_sensor_y, settings.quat_base_sensor_z});
}

void ImuReader::start() {
  status_ = parse_hid_descriptor(source_.descriptor(), layout_);
  if (status_ != Status::ok) return;
  const auto interval_ms = static_cast<unsigned>(std::lround(settings_.period_s * 1e3));
  for (const HidFeature& feature : layout_.features) {
    std::array<std::uint8_t, 64> report;
    const std::size_t bytes = make_feature_report(feature, interval_ms, report);
    if (bytes == 0 || source_.set_feature(std::span(report).first(bytes)) != Status::ok)
      status_ = Status::io_error;
  }
}

void ImuReader::poll(Nanoseconds deadline) {
  if (status_ != Status::ok) start();
  if (status_ != Status::ok) return;
  std::array<std::uint8_t, 256> report;
  for (int i = 0; i < kMaxReportsAtOnce; ++i) {
    const Result<std::size_t> n = source_.read(report, i == 0 ? deadline : 0);
    if (!n.ok()) {
      status_ = n.status();  // unplugged: start again with the next poll
      return;
    }
    if (*n == 0) return;
    take(std::span(report).first(*n));
  }
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
    if (whole) have_ |= 1u << static_cast<unsigned>(field.quantity);
  }
  if (!known || !whole) {
    ++bad_reports_;
    return;
  }
  if (have_ == kAllQuantities) complete();
}

void ImuReader::complete() {
  have_ = 0;
  const math::Mat3 R_base_sensor = math::rotation_matrix(quat_base_sensor_);
  const math::Vec3 gyro = R_base_sensor * gyro_, accel = R_base_sensor * accel_;
  const math::Quat quat =
      math::quat_multiply(quat_world_sensor_, math::quat_conjugate(quat_base_sensor_));
  const bool changed =
      gyro != sample_.gyro || accel != sample_.accel || quat != sample_.quat_world_base;
  sample_.time = clock_.now();
  ++sample_.sequence;
  if (changed) ++sample_.changes;
  sample_.gyro = gyro;
  sample_.accel = accel;
  sample_.quat_world_base = quat;
  out_.back() = sample_;
  out_.publish();
}

}  // namespace sanso::firmware
