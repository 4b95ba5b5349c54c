// The kernel's uevent files hold the numbers that do not change from plug to plug.
#include "firmware/board/hid_names.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace sanso::board {

std::string HidName::selector() const {
  char numbers[16];
  std::snprintf(numbers, sizeof numbers, "%04x:%04x", identity.vendor, identity.product);
  return numbers + (serial.empty() ? std::string() : ":" + serial);
}

std::vector<HidName> hid_names(const std::string& root) {
  namespace fs = std::filesystem;
  const fs::path top = (root.empty() ? fs::path("/") : fs::path(root)) / "sys/class/hidraw";
  std::vector<HidName> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(top, error)) {
    HidName name;
    name.node = entry.path().filename().string();
    std::ifstream uevent(entry.path() / "device/uevent");
    for (std::string line; std::getline(uevent, line);) {
      unsigned bus = 0, vendor = 0, product = 0;
      if (std::sscanf(line.c_str(), "HID_ID=%x:%x:%x", &bus, &vendor, &product) == 3)
        name.identity = {static_cast<std::uint16_t>(vendor), static_cast<std::uint16_t>(product)};
      if (line.rfind("HID_UNIQ=", 0) == 0) name.serial = line.substr(9);
      if (line.rfind("HID_NAME=", 0) == 0) name.product_name = line.substr(9);
    }
    found.push_back(name);
  }
  std::sort(found.begin(), found.end(),
            [](const HidName& a, const HidName& b) { return a.node < b.node; });
  return found;
}

std::optional<DeviceSelector> parse_selector(const std::string& text) {
  unsigned vendor = 0, product = 0;
  int used = 0;
  if (std::sscanf(text.c_str(), "%4x:%4x%n", &vendor, &product, &used) != 2) return std::nullopt;
  DeviceSelector selector;
  selector.identity = {static_cast<std::uint16_t>(vendor), static_cast<std::uint16_t>(product)};
  const std::string rest = text.substr(static_cast<std::size_t>(used));
  if (rest.empty()) return selector;
  if (rest.size() < 2 || rest[0] != ':') return std::nullopt;
  selector.serial = rest.substr(1);
  return selector;
}

}  // namespace sanso::board
