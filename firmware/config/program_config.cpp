// The configuration file by key: each setting's range comes from the struct that declares it.
#include "firmware/config/program_config.h"

#include <cmath>
#include <filesystem>
#include <type_traits>

#include "firmware/config/offsets_file.h"
#include "shared/base/time.h"
#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "shared/math/so3.h"

namespace sanso::firmware {
namespace {

using files::TomlTable;

constexpr const char* kPage = "one of the settings in docs/settings.md";

template <class T>
void read_setting(const TomlTable& table, const char* key, T& value, T low, T high) {
  if constexpr (std::is_same_v<T, bool>) {
    TomlTable::into(value, table.boolean(key));
  } else if constexpr (std::is_same_v<T, int>) {
    if (const auto given = table.integer(key, low, high)) value = static_cast<int>(*given);
  } else {
    TomlTable::into(value, table.number(key, low, high));
  }
}

void read_devices(const TomlTable& table, DeviceConfig& device) {
  TomlTable::into(device.bus, table.string("bus"));
  TomlTable::into(device.imu, table.string("imu"));
  TomlTable::into(device.pose, table.string("pose"));
  TomlTable::into(device.listen, table.string("listen"));
  read_setting(table, "port", device.port, 0, 65535);
  TomlTable::into(device.key_file, table.string("key_file"));
  TomlTable::into(device.robot_name, table.string("robot_name"));
  TomlTable::into(device.offsets, table.string("offsets"));
  TomlTable::into(device.log_directory, table.string("log_directory"));
  read_setting(table, "log_file_MB", device.log_file_MB, 1.0, 4000.0);
  read_setting(table, "log_file_minutes", device.log_file_minutes, 0.1, 1440.0);
  read_setting(table, "log_keep_MB", device.log_keep_MB, 0.0, 1e6);
  read_setting(table, "tick_priority", device.tick_priority, 1, 99);
  read_setting(table, "allow_without_realtime", device.allow_without_realtime, false, true);
  table.finish(kPage);
}

void read_config(const TomlTable& root, ProgramConfig& config) {
  if (const auto table = root.table("device")) read_devices(*table, config.device);
  config.settings.imu.from_board = config.device.imu == kBoardImu;
  config.settings.visit([&](const char* section, auto& group) {
    const auto table = root.table(section);
    if (!table) return;
    group.visit([&](const char* key, auto& value, auto low, auto high, const char*) {
      read_setting(*table, key, value, low, high);
    });
    table->finish(kPage);
  });
  root.finish("one of the sections in docs/settings.md");
}

/// Settings that are each inside their range and make no sense together; nullptr: none.
const char* conflict_of(const DeviceConfig& device, const Settings& s) {
  const math::Quat quat_base_sensor(s.imu.quat_base_sensor_w, s.imu.quat_base_sensor_x,
                                    s.imu.quat_base_sensor_y, s.imu.quat_base_sensor_z);
  if (s.guard.low_voltage_V < s.guard.min_voltage_V)
    return "guard.low_voltage_V is below guard.min_voltage_V: expected the warning above the fault";
  if (s.guard.warm_temperature_C >= s.guard.max_temperature_C)
    return "guard.warm_temperature_C is not below guard.max_temperature_C: expected the warning "
           "below the fault";
  if (s.guard.hot_duty > s.guard.max_duty)
    return "guard.hot_duty is above guard.max_duty: expected a hot servo to get less";
  if (s.guard.tilt_limit_rad >= s.guard.fall_tilt_rad)
    return "guard.tilt_limit_rad is not below guard.fall_tilt_rad: expected the warning below the "
           "fault";
  if (s.imu.late_s > s.imu.silent_s)
    return "imu.late_s is above imu.silent_s: expected the warning before the fault";
  if (s.imu.silent_s < 3 * s.imu.period_s)
    return "imu.silent_s is less than three times imu.period_s: a late report would be a fault";
  if (s.bus.reply_timeout_s + 0.004 > kTick_s)
    return "bus.reply_timeout_s and 4 ms for the slow read do not fit into a tick of 10 ms: "
           "expected at most 0.006";
  if (device.log_keep_MB != 0 && device.log_keep_MB < 2 * device.log_file_MB)
    return "device.log_keep_MB is less than two files of device.log_file_MB: expected room for "
           "the file being written and one before it, or 0 for no log of ticks";
  if (std::abs(quat_base_sensor.norm() - 1.0) > 0.01)
    return "imu.quat_base_sensor_w, x, y, z are not a rotation: expected norm 1";
  return nullptr;
}

}  // namespace

bool parse_program_config(const std::string& text, const std::string& name, ProgramConfig& config,
                          std::string& error) {
  error.clear();
  try {
    read_config(TomlTable::parse(text, name), config);
  } catch (const files::InputError& refused) {
    error = refused.what();
  }
  if (error.empty()) {
    if (const char* conflict = conflict_of(config.device, config.settings))
      error = name + ": " + conflict;
  }
  return error.empty();
}

bool read_program_config(const std::string& path, ProgramConfig& config, std::string& error) {
  try {
    if (!parse_program_config(files::read_text(path), path, config, error)) return false;
  } catch (const files::InputError& refused) {
    error = refused.what();
    return false;
  }
  if (config.device.offsets.empty()) return true;
  const auto offsets = std::filesystem::path(path).parent_path() / config.device.offsets;
  return read_offsets_file(offsets.string(), config.settings.bus.offset_rad, error);
}

}  // namespace sanso::firmware
