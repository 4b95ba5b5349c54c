// Finds the motion data in a HID sensor's report descriptor: which report, which bits, which scale.
// Fixed memory, for the IMU thread. Source: HID Sensor Usages (page 0x20); devices of makers with a
// layout of their own stand in a small table.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/board/board.h"
#include "shared/base/fixed_vector.h"
#include "shared/base/status.h"

namespace sanso::firmware {

/// What a sensor field means. Values in the order of the axes.
enum class HidQuantity : std::uint8_t { acceleration, angular_velocity, quaternion };

/// `count` numbers of `bits` bits, beginning at `first_bit` of an input report (report ID byte
/// included).
struct HidField {
  HidQuantity quantity = HidQuantity::acceleration;
  std::uint8_t component = 0;  // 0 x, 1 y, 2 z; a quaternion field holds x y z w at once
  std::uint8_t count = 1;
  std::uint8_t report_id = 0;
  std::uint16_t first_bit = 0;
  std::uint8_t bits = 0;
  bool is_signed = true;
  double scale = 1.0;  // raw to m/s^2, rad/s or 1
};

/// The feature report that switches a sensor on. Bits count from the ID byte on, which travels even
/// when it is 0 (a device that does not number its reports).
struct HidFeature {
  std::uint8_t report_id = 0;
  std::uint16_t reporting_state_bit = 0;
  std::uint16_t power_state_bit = 0;
  std::uint16_t interval_bit = 0;
  // bits of each; 0: not in the report
  std::uint8_t reporting_state_bits = 0, power_state_bits = 0, interval_bits = 0;
  std::uint8_t all_events_raw = 1;  // logical minimum + place of "all events" in the selector list
  std::uint8_t full_power_raw = 1;  // logical minimum + place of "D0"
  std::uint16_t bytes = 0;          // of the whole report, ID included
};

struct HidLayout {
  FixedVector<HidField, 24> fields;
  FixedVector<HidFeature, 8> features;
  bool has(HidQuantity quantity) const;
};

/// ok, malformed (items that contradict each other), full (more fields than fit) or unsupported (no
/// complete set of acceleration and angular velocity). A device without orientation is complete:
/// the reader estimates it. `identity` picks the layouts of makers that do not describe theirs.
Status parse_hid_descriptor(std::span<const std::uint8_t> descriptor, HidLayout& layout,
                            board::HidIdentity identity = {});

/// Sets "all events", "full power" and the interval in `report`, which holds the feature report as
/// the device has it now (or zeros) and keeps everything else. Bytes of the report; 0: it does not
/// fit.
std::size_t make_feature_report(const HidFeature& feature, unsigned interval_ms,
                                std::span<std::uint8_t> report);

/// The raw value of element `index` of a field; false when the report is too short.
bool read_hid_field(const HidField& field, int index, std::span<const std::uint8_t> report,
                    double& value);

}  // namespace sanso::firmware
