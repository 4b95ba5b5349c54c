// Settings of the emulator process, from a TOML file or the command line.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/emulator/emulated_robot.h"
#include "tools/emulator/fault_plan.h"

namespace sanso::emulator {

struct EmulatorConfig {
  std::string world = "lab";
  std::uint64_t seed = 1;
  std::string directory = "/tmp/sanso-robot";  // bus, imu, pose and control appear here
  std::int64_t baud = 2'000'000;
  bool hid_imu = true;             // false: no HID sensor, OpenCR's own is all there is
  bool usb = false;                // bus and IMU as USB devices of this kernel (vhci_hcd; root)
  std::vector<ServoSetup> servos;  // those that differ
  std::vector<Fault> faults;       // times count from the start of the process
};

/// Reads FILE; unknown keys, unknown fault names and values outside their range are refused with
/// file and line.
/// Throws plant::WorldError.
EmulatorConfig load_emulator_config(const std::string& path);

}  // namespace sanso::emulator
