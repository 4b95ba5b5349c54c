// What is plugged in and could be the robot's bus or IMU, for the owner: `sanso-firmware
// --devices`. Reads /dev and /sys below `root` ("" on a machine, a folder in tests).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "firmware/board/board.h"

namespace sanso::board {

/// A device, what to write into the settings for it, and why it cannot be used (empty: it can).
struct ListedDevice {
  std::string setting;  // bus = "..." or imu = "..."
  std::string what;     // driver, numbers, latency
  std::string obstacle;
};

/// Serial devices of USB adapters, by their stable names where there are any.
std::vector<ListedDevice> list_ttys(const std::string& root);

/// Why a device with this descriptor is no IMU; empty: it is one.
using HidJudge = std::function<std::string(std::span<const std::uint8_t>, HidIdentity)>;
/// HID devices that the kernel shows as hidraw.
std::vector<ListedDevice> list_hidraw(const std::string& root, const HidJudge& judge);

/// FTDI chips and HID devices as libusb and hidapi see them; empty without the libraries.
std::vector<ListedDevice> list_ftdi();
std::vector<ListedDevice> list_hidapi(const HidJudge& judge);

/// "heading", and one line a device; says so when there is none.
std::string device_table(const std::string& heading, const std::vector<ListedDevice>& devices);

}  // namespace sanso::board
