// The items of a HID report descriptor, read once from front to back: every main item that
// describes data is handed on with what the standard's global and local items say about it. Knows
// nothing of sensors. Fixed memory. Source: USB HID 1.11, section 6.2.2.
#pragma once

#include <cstdint>
#include <span>

#include "shared/base/fixed_vector.h"
#include "shared/base/status.h"

namespace sanso::firmware {

/// Usages of one item, page in the upper half: one usage, or all of a minimum .. maximum.
struct HidUsages {
  std::uint32_t first = 0, last = 0;
};

/// One Input or Feature item.
struct HidItem {
  bool feature = false;
  bool constant = false;        // padding
  std::uint8_t report_id = 0;   // 0: reports of this device are not numbered
  std::uint32_t first_bit = 0;  // in the report; the ID byte is counted when there is one
  std::uint32_t bits = 0, count = 0;
  std::int32_t logical_minimum = 0;
  std::uint32_t unit = 0, unit_exponent = 0;
  std::span<const HidUsages> usages;
  std::uint32_t property = 0;     // usage before the logical collection around it, 0: none
  std::uint32_t application = 0;  // usage of the outermost collection

  /// Usage of element `index`; 0 when the item names fewer.
  std::uint32_t usage(std::uint32_t index) const;
};

class HidItemSink {
 public:
  /// Anything but ok ends the reading with that status.
  virtual Status take(const HidItem& item) = 0;

 protected:
  ~HidItemSink() = default;
};

struct HidReportSize {
  std::uint8_t id = 0;
  bool feature = false;
  std::uint32_t bits = 0;  // ID byte included
};
using HidReportSizes = FixedVector<HidReportSize, 32>;

/// ok, malformed (items that contradict each other or end too early), full (more than fits), or
/// what the sink said. A feature report always counts an ID byte: that is how it travels.
Status read_hid_items(std::span<const std::uint8_t> descriptor, HidItemSink& sink,
                      HidReportSizes& sizes);

}  // namespace sanso::firmware
