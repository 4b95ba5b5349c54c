// Keeps what is motion or switches the sensor on; computes the scale from unit and exponent once.
#include "firmware/imu/hid_descriptor.h"

#include <algorithm>
#include <cmath>

#include "firmware/exchange/samples.h"
#include "firmware/imu/hid_items.h"
#include "shared/model/joints.h"

namespace sanso::firmware {
namespace {

using model::kPi;

constexpr std::uint32_t kSensorPage = 0x20;
constexpr std::uint16_t kReportingState = 0x0316, kPowerState = 0x0319, kReportInterval = 0x030E;
constexpr std::uint16_t kAllEvents = 0x0841, kPowerD0 = 0x0851;
constexpr std::uint16_t kAccelerationX = 0x0453, kAngularVelocityX = 0x0457, kQuaternion = 0x0483;

/// Unit codes: those of the standard's encoding, and as a table in use elsewhere lists them
/// (byte-swapped).
double unit_scale(HidQuantity quantity, std::uint32_t unit) {
  switch (quantity) {
    case HidQuantity::acceleration:
      return unit == 0xE011 || unit == 0x11E0 ? 1.0 : kStandardGravity;
    case HidQuantity::angular_velocity:
      return unit == 0xF012 || unit == 0x12F0 ? 1.0 : kPi / 180.0;
    case HidQuantity::quaternion:
      return 1.0;
  }
  return 1.0;
}

/// Exponent nibble: four bits, two's complement.
int exponent_of(std::uint32_t nibble) {
  const int n = static_cast<int>(nibble & 0xF);
  return n < 8 ? n : n - 16;
}

/// A device whose motion data lie at fixed places that its descriptor does not name: three gyro
/// numbers, then three accelerations, i16 each, little-endian.
struct VendorLayout {
  std::uint16_t vendor, product;
  std::uint8_t report_id;
  std::uint8_t gyro_byte, accel_byte;  // in the report, ID byte included
  double gyro_counts_per_deg_s, accel_counts_per_g;
};

// Uncalibrated, as the chips' ranges of 2000 deg/s and 4 g give it. Places: Linux hid-playstation.
constexpr std::array kVendorLayouts{
    VendorLayout{0x054C, 0x0CE6, 0x01, 16, 22, 16.384, 8192.0},  // DualSense
    VendorLayout{0x054C, 0x09CC, 0x01, 13, 19, 16.384, 8192.0},  // DualShock 4, second version
    VendorLayout{0x054C, 0x05C4, 0x01, 13, 19, 16.384, 8192.0},  // DualShock 4
};

bool add_vendor_fields(board::HidIdentity id, HidLayout& layout) {
  const auto known = std::find_if(
      kVendorLayouts.begin(), kVendorLayouts.end(),
      [&](const VendorLayout& v) { return v.vendor == id.vendor && v.product == id.product; });
  if (known == kVendorLayouts.end()) return false;
  layout.fields.clear();
  layout.features.clear();
  for (std::uint8_t axis = 0; axis < 3; ++axis) {
    HidField field;
    field.component = axis;
    field.report_id = known->report_id;
    field.bits = 16;
    field.quantity = HidQuantity::angular_velocity;
    field.first_bit = static_cast<std::uint16_t>(8 * known->gyro_byte + 16 * axis);
    field.scale = kPi / 180.0 / known->gyro_counts_per_deg_s;
    (void)layout.fields.try_push(field);
    field.quantity = HidQuantity::acceleration;
    field.first_bit = static_cast<std::uint16_t>(8 * known->accel_byte + 16 * axis);
    field.scale = kStandardGravity / known->accel_counts_per_g;
    (void)layout.fields.try_push(field);
  }
  return true;
}

std::uint16_t sensor_usage(std::uint32_t full) {
  return (full >> 16) == kSensorPage ? static_cast<std::uint16_t>(full) : std::uint16_t{0};
}

/// Picks the motion data and the switches out of all items.
class SensorSink final : public HidItemSink {
 public:
  explicit SensorSink(HidLayout& layout) : layout_(layout) {}
  Status take(const HidItem& item) override {
    if (item.constant) return Status::ok;
    return item.feature ? take_feature(item) : take_input(item);
  }

 private:
  Status take_input(const HidItem& item) {
    for (std::uint32_t e = 0; e < item.count; ++e) {
      const std::uint16_t usage = sensor_usage(item.usage(e));
      HidField field;
      field.first_bit = static_cast<std::uint16_t>(item.first_bit + e * item.bits);
      if (usage >= kAccelerationX && usage < kAccelerationX + 3) {
        field.quantity = HidQuantity::acceleration;
        field.component = static_cast<std::uint8_t>(usage - kAccelerationX);
      } else if (usage >= kAngularVelocityX && usage < kAngularVelocityX + 3) {
        field.quantity = HidQuantity::angular_velocity;
        field.component = static_cast<std::uint8_t>(usage - kAngularVelocityX);
      } else if (usage == kQuaternion && item.count == 4) {
        field.quantity = HidQuantity::quaternion;
        field.count = 4;
      } else {
        continue;
      }
      field.report_id = item.report_id;
      field.bits = static_cast<std::uint8_t>(item.bits);
      field.is_signed = item.logical_minimum < 0;
      field.scale =
          unit_scale(field.quantity, item.unit) * std::pow(10.0, exponent_of(item.unit_exponent));
      if (field.bits == 0 || !layout_.fields.try_push(field)) return Status::full;
    }
    return Status::ok;
  }

  static std::uint8_t selector_raw(const HidItem& item, std::uint16_t wanted) {
    // unsigned: a device may claim that its selectors begin at the largest number there is
    const auto first = static_cast<std::uint32_t>(item.logical_minimum);
    for (std::uint32_t i = 0; i < 256 && item.usage(i) != 0; ++i)
      if (sensor_usage(item.usage(i)) == wanted) return static_cast<std::uint8_t>(first + i);
    return 1;
  }

  HidFeature* feature_of(std::uint8_t id) {
    for (HidFeature& f : layout_.features)
      if (f.report_id == id) return &f;
    if (!layout_.features.try_push({})) return nullptr;
    layout_.features.back().report_id = id;
    return &layout_.features.back();
  }

  Status take_feature(const HidItem& item) {
    const std::uint16_t usage = sensor_usage(item.property != 0 ? item.property : item.usage(0));
    if (usage != kReportingState && usage != kPowerState && usage != kReportInterval)
      return Status::ok;
    HidFeature* feature = feature_of(item.report_id);
    if (feature == nullptr) return Status::full;
    const auto bit = static_cast<std::uint16_t>(item.first_bit);
    const auto size = static_cast<std::uint8_t>(item.bits);
    if (usage == kReportingState) {
      feature->reporting_state_bit = bit;
      feature->reporting_state_bits = size;
      feature->all_events_raw = selector_raw(item, kAllEvents);
    } else if (usage == kPowerState) {
      feature->power_state_bit = bit;
      feature->power_state_bits = size;
      feature->full_power_raw = selector_raw(item, kPowerD0);
    } else {
      feature->interval_bit = bit;
      feature->interval_bits = size;
    }
    return Status::ok;
  }

  HidLayout& layout_;
};

void put_bits(std::span<std::uint8_t> report, std::uint32_t first_bit, unsigned bits,
              std::uint32_t value) {
  for (unsigned b = 0; b < bits; ++b) {
    const std::uint32_t at = first_bit + b;
    if (at / 8 >= report.size()) return;
    const auto mask = static_cast<std::uint8_t>(1u << (at % 8));
    std::uint8_t& byte = report[at / 8];
    const bool one = b < 32 && ((value >> b) & 1u) != 0;
    byte = static_cast<std::uint8_t>(one ? byte | mask : byte & ~mask);
  }
}

}  // namespace

bool HidLayout::has(HidQuantity quantity) const {
  unsigned components = 0;
  for (const HidField& f : fields)
    if (f.quantity == quantity) components |= f.count == 4 ? 7u : 1u << f.component;
  return components == 7u;
}

Status parse_hid_descriptor(std::span<const std::uint8_t> descriptor, HidLayout& layout,
                            board::HidIdentity identity) {
  layout.fields.clear();
  layout.features.clear();
  SensorSink sink(layout);
  HidReportSizes sizes;
  if (const Status status = read_hid_items(descriptor, sink, sizes); status != Status::ok)
    return status;
  for (HidFeature& feature : layout.features)
    for (const HidReportSize& size : sizes)
      if (size.feature && size.id == feature.report_id)
        feature.bytes = static_cast<std::uint16_t>((size.bits + 7) / 8);
  const bool complete =
      layout.has(HidQuantity::acceleration) && layout.has(HidQuantity::angular_velocity);
  return complete || add_vendor_fields(identity, layout) ? Status::ok : Status::unsupported;
}

std::size_t make_feature_report(const HidFeature& feature, unsigned interval_ms,
                                std::span<std::uint8_t> report) {
  if (feature.bytes == 0 || feature.bytes > report.size()) return 0;
  report = report.first(feature.bytes);
  report[0] = feature.report_id;
  put_bits(report, feature.reporting_state_bit, feature.reporting_state_bits,
           feature.all_events_raw);
  put_bits(report, feature.power_state_bit, feature.power_state_bits, feature.full_power_raw);
  put_bits(report, feature.interval_bit, feature.interval_bits, interval_ms);
  return feature.bytes;
}

bool read_hid_field(const HidField& field, int index, std::span<const std::uint8_t> report,
                    double& value) {
  const std::uint32_t first = field.first_bit + static_cast<std::uint32_t>(index) * field.bits;
  if (field.bits == 0 || first + field.bits > report.size() * 8) return false;
  std::uint64_t raw = 0;
  for (std::uint32_t b = 0; b < field.bits; ++b) {
    const std::uint32_t at = first + b;
    raw |= static_cast<std::uint64_t>((report[at / 8] >> (at % 8)) & 1u) << b;
  }
  const std::uint64_t sign = std::uint64_t{1} << (field.bits - 1);
  const bool negative = field.is_signed && (raw & sign) != 0;
  const double number =
      static_cast<double>(raw) - (negative ? 2.0 * static_cast<double>(sign) : 0.0);
  value = number * field.scale;
  return true;
}

}  // namespace sanso::firmware
