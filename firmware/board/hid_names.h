// Which HID device is which /dev/hidrawN today: numbers move at every plug, vendor, product and
// serial number stay.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/board/board.h"

namespace sanso::board {

struct HidName {
  std::string node;  // hidraw0
  HidIdentity identity;
  std::string serial, product_name;
  /// "1209:0001:serial", as a device setting names it.
  std::string selector() const;
};

/// All hidraw devices of the kernel, from /sys below `root`.
std::vector<HidName> hid_names(const std::string& root = {});

/// Vendor, product and perhaps serial number of "VID:PID" or "VID:PID:SERIAL" (hexadecimal).
struct DeviceSelector {
  HidIdentity identity;
  std::string serial;  // empty: any
};
std::optional<DeviceSelector> parse_selector(const std::string& text);

}  // namespace sanso::board
