// What a HID device is, in words, for the owner: every report with its fields, and what is missing
// for an IMU. Allocates: not for the IMU thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "firmware/board/board.h"

namespace sanso::firmware {

/// "input report 1: acceleration x, y, z (16 bit)", one line a report and usage page.
std::string describe_hid(std::span<const std::uint8_t> descriptor);

/// Why a device with this descriptor cannot be the IMU, and what it is instead; empty when it can.
std::string why_no_imu(std::span<const std::uint8_t> descriptor, board::HidIdentity identity = {});

}  // namespace sanso::firmware
