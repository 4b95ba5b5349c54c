// The configuration file by key: each setting's range comes from the struct that declares it.
#include "firmware/config/program_config.h"

#include <filesystem>
#include <type_traits>

#include "firmware/config/offsets_file.h"
#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/files/toml.h"

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
  TomlTable::into(device.offsets, table.string("offsets"));
  TomlTable::into(device.log_directory, table.string("log_directory"));
  read_setting(table, "tick_priority", device.tick_priority, 1, 99);
  table.finish(kPage);
}

void read_config(const TomlTable& root, ProgramConfig& config) {
  if (const auto table = root.table("device")) read_devices(*table, config.device);
  config.settings.imu.from_board = config.device.imu == "opencr";
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

}  // namespace

bool parse_program_config(const std::string& text, const std::string& name, ProgramConfig& config,
                          std::string& error) {
  error.clear();
  try {
    read_config(TomlTable::parse(text, name), config);
  } catch (const files::InputError& refused) {
    error = refused.what();
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
