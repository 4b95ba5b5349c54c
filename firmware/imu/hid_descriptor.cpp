// One pass over the descriptor's items; long items and usages without motion data are passed
// over, their bits counted.
#include "firmware/imu/hid_descriptor.h"

#include <algorithm>
#include <cmath>

namespace sanso::firmware {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kStandardGravity = 9.80665;

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

struct Globals {
  std::uint32_t usage_page = 0;
  std::int32_t logical_minimum = 0;
  std::uint32_t unit = 0, unit_exponent = 0;
  std::uint32_t report_size = 0, report_count = 0;
  std::uint8_t report_id = 0;
};

struct ReportBits {
  std::uint8_t id = 0;
  bool feature = false;
  std::uint32_t bits = 8;  // the ID byte
};

class DescriptorParser {
 public:
  DescriptorParser(std::span<const std::uint8_t> bytes, HidLayout& layout)
      : bytes_(bytes), layout_(layout) {}

  Status run() {
    while (at_ < bytes_.size()) {
      if (const Status status = item(); status != Status::ok) return status;
    }
    for (HidFeature& feature : layout_.features)
      feature.bytes = static_cast<std::uint16_t>(bits_of(feature.report_id, true) / 8);
    return depth_ == 0 ? Status::ok : Status::malformed;
  }

 private:
  Status item() {
    const std::uint8_t prefix = bytes_[at_++];
    if (prefix == 0xFE) return skip_long_item();
    const std::size_t size = (prefix & 3) == 3 ? 4 : (prefix & 3);
    if (bytes_.size() - at_ < size) return Status::malformed;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value |= static_cast<std::uint32_t>(bytes_[at_ + i]) << (8 * i);
    at_ += size;
    switch (prefix & 0xFC) {
      // global items
      case 0x04:
        globals_.usage_page = value;
        break;
      case 0x14:
        globals_.logical_minimum = sign_extended(value, size);
        break;
      case 0x54:
        globals_.unit_exponent = value;
        break;
      case 0x64:
        globals_.unit = value;
        break;
      case 0x74:
        globals_.report_size = value;
        break;
      case 0x84:
        globals_.report_id = static_cast<std::uint8_t>(value);
        break;
      case 0x94:
        globals_.report_count = value;
        break;
      // local items
      case 0x08:
        if (!usages_.try_push(size == 4 ? value : (globals_.usage_page << 16) | value))
          return Status::full;
        break;
      // main items
      case 0xA0:
        ++depth_;
        // a logical collection holds the selectors of the property named just before it
        if (value == 2 && !usages_.empty()) property_ = usages_.back();
        usages_.clear();
        break;
      case 0xC0:
        if (depth_-- == 0) return Status::malformed;
        property_ = 0;
        usages_.clear();
        break;
      case 0x80:
        return main_field(value, false);
      case 0xB0:
        return main_field(value, true);
      default:
        break;  // items that say nothing about where the data lie
    }
    return Status::ok;
  }

  Status skip_long_item() {
    if (bytes_.size() - at_ < 2 || bytes_.size() - at_ - 2 < bytes_[at_]) return Status::malformed;
    at_ += 2u + bytes_[at_];
    return Status::ok;
  }

  static std::int32_t sign_extended(std::uint32_t value, std::size_t size) {
    if (size == 1) return static_cast<std::int8_t>(value);
    if (size == 2) return static_cast<std::int16_t>(value);
    return static_cast<std::int32_t>(value);
  }

  std::uint32_t& bits_of(std::uint8_t id, bool feature) {
    for (ReportBits& r : reports_)
      if (r.id == id && r.feature == feature) return r.bits;
    if (!reports_.try_push({id, feature, id == 0 ? 0u : 8u})) {
      overflow_ = true;
      return spare_.bits;
    }
    return reports_.back().bits;
  }

  Status main_field(std::uint32_t flags, bool feature) {
    if (globals_.report_size > 32 || globals_.report_count > 64) return Status::malformed;
    std::uint32_t& bits = bits_of(globals_.report_id, feature);
    if (overflow_ || bits > 4096) return Status::full;
    const bool constant = (flags & 1) != 0;
    Status status = Status::ok;
    if (!constant) status = feature ? feature_field(bits) : input_field(bits);
    bits += globals_.report_size * globals_.report_count;
    usages_.clear();
    return status;
  }

  static std::uint16_t usage_of(std::uint32_t full) {
    return (full >> 16) == kSensorPage ? static_cast<std::uint16_t>(full) : std::uint16_t{0};
  }

  Status input_field(std::uint32_t first_bit) {
    for (std::uint32_t e = 0; e < globals_.report_count && e < usages_.size(); ++e) {
      const std::uint16_t usage = usage_of(usages_[e]);
      HidField field;
      field.first_bit = static_cast<std::uint16_t>(first_bit + e * globals_.report_size);
      if (usage >= kAccelerationX && usage < kAccelerationX + 3) {
        field.quantity = HidQuantity::acceleration;
        field.component = static_cast<std::uint8_t>(usage - kAccelerationX);
      } else if (usage >= kAngularVelocityX && usage < kAngularVelocityX + 3) {
        field.quantity = HidQuantity::angular_velocity;
        field.component = static_cast<std::uint8_t>(usage - kAngularVelocityX);
      } else if (usage == kQuaternion && globals_.report_count == 4) {
        field.quantity = HidQuantity::quaternion;
        field.count = 4;
      } else {
        continue;
      }
      field.report_id = globals_.report_id;
      field.bits = static_cast<std::uint8_t>(globals_.report_size);
      field.is_signed = globals_.logical_minimum < 0;
      field.scale = unit_scale(field.quantity, globals_.unit) *
                    std::pow(10.0, exponent_of(globals_.unit_exponent));
      if (field.bits == 0 || !layout_.fields.try_push(field)) return Status::full;
    }
    return Status::ok;
  }

  std::uint8_t selector_raw(std::uint16_t wanted) const {
    for (std::size_t i = 0; i < usages_.size(); ++i)
      if (usage_of(usages_[i]) == wanted)
        return static_cast<std::uint8_t>(globals_.logical_minimum + static_cast<int>(i));
    return 1;
  }

  Status feature_field(std::uint32_t first_bit) {
    HidFeature* feature = nullptr;
    for (HidFeature& f : layout_.features)
      if (f.report_id == globals_.report_id) feature = &f;
    if (feature == nullptr) {
      if (!layout_.features.try_push({})) return Status::full;
      feature = &layout_.features.back();
      feature->report_id = globals_.report_id;
    }
    const std::uint16_t usage =
        usage_of(property_ != 0 ? property_ : (usages_.empty() ? 0 : usages_[0]));
    const auto bit = static_cast<std::uint16_t>(first_bit);
    const auto size = static_cast<std::uint8_t>(globals_.report_size);
    if (usage == kReportingState) {
      feature->reporting_state_bit = bit;
      feature->reporting_state_bits = size;
      feature->all_events_raw = selector_raw(kAllEvents);
    } else if (usage == kPowerState) {
      feature->power_state_bit = bit;
      feature->power_state_bits = size;
      feature->full_power_raw = selector_raw(kPowerD0);
    } else if (usage == kReportInterval) {
      feature->interval_bit = bit;
      feature->interval_bits = size;
    }
    return Status::ok;
  }

  std::span<const std::uint8_t> bytes_;
  HidLayout& layout_;
  std::size_t at_ = 0;
  int depth_ = 0;
  Globals globals_;
  FixedVector<std::uint32_t, 64> usages_;
  std::uint32_t property_ = 0;
  FixedVector<ReportBits, 32> reports_;
  ReportBits spare_;
  bool overflow_ = false;
};

void put_bits(std::span<std::uint8_t> report, std::uint32_t first_bit, unsigned bits,
              std::uint32_t value) {
  for (unsigned b = 0; b < bits; ++b) {
    const std::uint32_t at = first_bit + b;
    if (at / 8 >= report.size()) return;
    if ((value >> b) & 1u)
      report[at / 8] = static_cast<std::uint8_t>(report[at / 8] | (1u << (at % 8)));
  }
}

}  // namespace

bool HidLayout::has(HidQuantity quantity) const {
  unsigned components = 0;
  for (const HidField& f : fields)
    if (f.quantity == quantity) components |= f.count == 4 ? 7u : 1u << f.component;
  return components == 7u;
}

Status parse_hid_descriptor(std::span<const std::uint8_t> descriptor, HidLayout& layout) {
  layout.fields.clear();
  layout.features.clear();
  if (const Status status = DescriptorParser(descriptor, layout).run(); status != Status::ok)
    return status;
  const bool complete = layout.has(HidQuantity::acceleration) &&
                        layout.has(HidQuantity::angular_velocity) &&
                        layout.has(HidQuantity::quaternion);
  return complete ? Status::ok : Status::unsupported;
}

std::size_t make_feature_report(const HidFeature& feature, unsigned interval_ms,
                                std::span<std::uint8_t> out) {
  if (feature.bytes > out.size()) return 0;
  const auto report = out.first(feature.bytes);
  std::fill(report.begin(), report.end(), std::uint8_t{0});
  if (feature.report_id != 0 && !report.empty()) report[0] = feature.report_id;
  if (feature.reporting_state_bits != 0)
    put_bits(report, feature.reporting_state_bit, feature.reporting_state_bits,
             feature.all_events_raw);
  if (feature.power_state_bits != 0)
    put_bits(report, feature.power_state_bit, feature.power_state_bits, feature.full_power_raw);
  if (feature.interval_bits != 0)
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
