// Writes the descriptor that a host parses, and reports at the rates it has switched on, with
// bias, noise and quantum.
#include "tools/emulator/hid_imu.h"

#include <algorithm>
#include <cmath>

#include "shared/servo_bus/packet.h"

namespace sanso::emulator {

using plant::operator*;
using plant::operator+;
using plant::operator-;

namespace {

constexpr double kAccelScale = 1e-3 * 9.80665;                      // a count in m/s^2: 1e-3 g
constexpr double kGyroScale = 1e-4 * 3.14159265358979323846 / 180;  // a count in rad/s: 1e-4 deg/s
constexpr double kQuaternionScale = 1e-7;
constexpr std::uint8_t kReady = 1, kDataUpdated = 3;
constexpr std::size_t kFeatureBytes = 7;
constexpr std::size_t kQueueLimit = 64;  // as the kernel's hidraw ring: the oldest report is lost

/// Short item: one tag byte, data of 1, 2 or 4 bytes.
void item(std::vector<std::uint8_t>& out, std::uint8_t tag, std::uint32_t value, int size) {
  out.push_back(tag);
  for (int i = 0; i < size; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// A one-byte array field whose value is an index into `count` selectors from `first_selector` on.
void selector_field(std::vector<std::uint8_t>& d, std::uint16_t usage, std::uint16_t first_selector,
                    int count, std::uint8_t main_tag) {
  item(d, 0x0A, usage, 2);
  item(d, 0x15, 0, 1);
  item(d, 0x25, static_cast<std::uint32_t>(count - 1), 1);
  item(d, 0x75, 8, 1);
  item(d, 0x95, 1, 1);
  item(d, 0xA1, 0x02, 1);
  for (int i = 0; i < count; ++i) item(d, 0x0A, static_cast<std::uint32_t>(first_selector + i), 2);
  item(d, main_tag, 0x00, 1);
  d.push_back(0xC0);
}

struct SensorLayout {
  std::uint8_t usage;
  std::uint8_t report_id;
  std::vector<std::uint16_t> data_usages;
  int bits;
  int count;
  std::uint8_t exponent;  // four-bit two's complement
};

void sensor_collection(std::vector<std::uint8_t>& d, const SensorLayout& s) {
  constexpr std::uint8_t kInput = 0x81, kFeature = 0xB1;
  item(d, 0x09, s.usage, 1);
  item(d, 0xA1, 0x00, 1);
  item(d, 0x85, s.report_id, 1);
  // unit exponent: global items persist from the sensor before
  item(d, 0x55, 0x00, 1);
  selector_field(d, 0x0316, 0x0840, 6, kFeature);  // reporting state
  selector_field(d, 0x0319, 0x0850, 6, kFeature);  // power state
  item(d, 0x0A, 0x030E, 2);                        // report interval, ms
  item(d, 0x15, 0, 1);
  item(d, 0x27, 0x7FFFFFFF, 4);
  item(d, 0x75, 32, 1);
  item(d, 0x95, 1, 1);
  item(d, 0x55, 0x00, 1);
  item(d, kFeature, 0x02, 1);
  selector_field(d, 0x0201, 0x0800, 7, kInput);  // sensor state
  selector_field(d, 0x0202, 0x0810, 6, kInput);  // sensor event
  for (const std::uint16_t usage : s.data_usages) item(d, 0x0A, usage, 2);
  if (s.bits == 16) {
    item(d, 0x16, 0x8001, 2);
    item(d, 0x26, 0x7FFF, 2);
  } else {
    item(d, 0x17, 0x80000001, 4);
    item(d, 0x27, 0x7FFFFFFF, 4);
  }
  item(d, 0x75, static_cast<std::uint32_t>(s.bits), 1);
  item(d, 0x95, static_cast<std::uint32_t>(s.count), 1);
  item(d, 0x55, s.exponent, 1);
  item(d, kInput, 0x02, 1);
  d.push_back(0xC0);
}

std::vector<std::uint8_t> make_descriptor() {
  std::vector<std::uint8_t> d;
  item(d, 0x05, 0x20, 1);  // usage page: sensors
  item(d, 0x09, 0x01, 1);
  item(d, 0xA1, 0x01, 1);
  sensor_collection(d, {0x73, 1, {0x0453, 0x0454, 0x0455}, 16, 3, 0x0D});
  sensor_collection(d, {0x76, 2, {0x0457, 0x0458, 0x0459}, 32, 3, 0x0C});
  sensor_collection(d, {0x8A, 3, {0x0483}, 32, 4, 0x09});
  d.push_back(0xC0);
  return d;
}

void put_counts(std::vector<std::uint8_t>& out, double value, double scale, std::size_t bytes) {
  const double limit = bytes == 2 ? 32767.0 : 2147483647.0;
  std::uint8_t field[4];
  servo_bus::put_le(
      field, bytes,
      static_cast<std::int64_t>(std::llround(std::clamp(value / scale, -limit, limit))));
  out.insert(out.end(), field, field + bytes);
}

}  // namespace

HidImu::HidImu(const plant::ImuParameters& parameters, std::uint64_t seed)
    : parameters_(parameters), random_(seed) {}

std::span<const std::uint8_t> HidImu::descriptor() {
  static const std::vector<std::uint8_t> bytes = make_descriptor();
  return bytes;
}

plant::Vec3 HidImu::noisy(const plant::Vec3& value, const plant::Vec3& bias, double deviation) {
  plant::Vec3 out = value + bias;
  for (double& component : out) component += deviation * random_.normal();
  return out;
}

HidImu::Report HidImu::make_report(int sensor, const ImuTruth& truth) {
  Report report{static_cast<std::uint8_t>(sensor + 1), kReady, kDataUpdated};
  if (sensor == 0) {
    const auto value =
        noisy(truth.specific_force, parameters_.accel_bias_m_s2, parameters_.accel_noise_m_s2);
    for (const double axis : value) put_counts(report, axis, kAccelScale, 2);
  } else if (sensor == 1) {
    const auto value = noisy(truth.rate, parameters_.gyro_bias_rad_s, parameters_.gyro_noise_rad_s);
    for (const double axis : value) put_counts(report, axis, kGyroScale, 4);
  } else {
    const auto tilt =
        noisy({0, 0, 0}, parameters_.orientation_bias_rad, parameters_.orientation_noise_rad);
    auto q = plant::multiply(truth.quat_world_base, plant::from_rotation_vector(tilt + error_));
    if (heading_error_ != 0.0)
      q = plant::multiply(plant::from_rotation_vector({0, 0, heading_error_}), q);
    // x y z w
    for (const double part : {q[1], q[2], q[3], q[0]})
      put_counts(report, part, kQuaternionScale, 4);
  }
  return report;
}

/// The sensor's own filter: heading runs away, and up is drawn towards the felt force.
void HidImu::drift(const ImuTruth& truth) {
  constexpr double kPeriod_s = 0.001;
  heading_error_ += kPeriod_s * parameters_.yaw_drift_rad_s;
  const double felt = plant::norm(truth.specific_force);
  if (parameters_.gravity_filter_s <= 0.0 || felt < 1.0) return;
  const plant::Vec3 up = plant::rotate(plant::conjugate(truth.quat_world_base), {0, 0, 1});
  const plant::Vec3 apparent = plant::cross((1.0 / felt) * truth.specific_force, up);
  error_ = error_ + (kPeriod_s / parameters_.gravity_filter_s) * (apparent - error_);
}

void HidImu::update(Nanoseconds now, const ImuTruth& truth, bool silent, bool frozen) {
  drift(truth);
  for (int i = 0; i < 3; ++i) {
    Sensor& sensor = sensors_[i];
    if (!sensor.active() || now < sensor.next) continue;
    sensor.next = now + sensor.interval_ms * kMillisecond;
    if (!frozen || last_[i].empty()) last_[i] = make_report(i, truth);
    if (!silent) due_.push_back(last_[i]);
  }
  // a full-speed interrupt endpoint delivers one report a millisecond
  if (!due_.empty()) {
    ready_.push_back(std::move(due_.front()));
    due_.pop_front();
  }
  while (ready_.size() > kQueueLimit) ready_.pop_front();
  while (due_.size() > kQueueLimit) due_.pop_front();
}

std::size_t HidImu::read(std::span<std::uint8_t> out) {
  if (ready_.empty() || out.size() < ready_.front().size()) return 0;
  const Report report = std::move(ready_.front());
  ready_.pop_front();
  std::copy(report.begin(), report.end(), out.begin());
  return report.size();
}

bool HidImu::set_feature(std::span<const std::uint8_t> report) {
  if (report.size() != kFeatureBytes || report[0] < 1 || report[0] > 3 || report[1] > 5 ||
      report[2] > 5)
    return false;
  Sensor& sensor = sensors_[report[0] - 1];
  sensor.reporting = report[1];
  sensor.power = report[2];
  sensor.interval_ms = std::max<std::uint32_t>(1, servo_bus::get_u32(report.subspan(3)));
  sensor.next = 0;
  return true;
}

std::size_t HidImu::get_feature(std::uint8_t report_id, std::span<std::uint8_t> out) const {
  if (report_id < 1 || report_id > 3 || out.size() < kFeatureBytes) return 0;
  const Sensor& sensor = sensors_[report_id - 1];
  out[0] = report_id;
  out[1] = sensor.reporting;
  out[2] = sensor.power;
  servo_bus::put_le(&out[3], 4, sensor.interval_ms);
  return kFeatureBytes;
}

}  // namespace sanso::emulator
