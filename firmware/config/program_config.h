// The controller program's configuration file: devices and addresses, and every setting of
// settings.h by name. Read once at start; an unknown key, a wrong type or a value out of range is
// an error that names it. Not real-time.
#pragma once

#include <string>

#include "firmware/config/settings.h"

namespace sanso::firmware {

/// DeviceConfig::imu of a sensor on the OpenCR board, which is read over the servo bus.
inline constexpr const char* kBoardImu = "opencr";

struct DeviceConfig {
  std::string bus = "/dev/ttyUSB0";  // serial device of the servo bus
  std::string imu = "/dev/hidraw0";  // docs/howto/robot.md lists the forms
  std::string pose;                  // unix:PATH of a pose bridge; empty: none
  std::string listen = "0.0.0.0";    // address for hosts
  int port = 7531;                   // UDP port for hosts
  std::string key_file;              // 64 hexadecimal digits, the pre-shared key; mode 0600
  std::string robot_name = "op3";    // told to whoever asks (at most 31 characters)
  std::string offsets;               // offset.yaml of the robot; empty: none
  std::string log_directory;     // every tick, and a record of each fault; empty: none are written
  double log_file_MB = 64;       // a file of ticks is closed at this size,
  double log_file_minutes = 10;  // or at this age
  double log_keep_MB = 1000;     // all files of ticks together; 0: no ticks are written
  int tick_priority = 80;        // SCHED_FIFO
  // torque may come on although the machine grants neither real-time priority nor locked memory
  bool allow_without_realtime = false;
};

struct ProgramConfig {
  DeviceConfig device;
  Settings settings;
};

/// Reads `path` and the offsets file that it names (relative to it). On failure returns false and
/// `error` says file, line, key, value and what was expected.
bool read_program_config(const std::string& path, ProgramConfig& config, std::string& error);
/// The same from text; `name` stands for the file in messages.
bool parse_program_config(const std::string& text, const std::string& name, ProgramConfig& config,
                          std::string& error);

}  // namespace sanso::firmware
