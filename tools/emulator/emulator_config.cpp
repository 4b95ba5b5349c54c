// The keys of the configuration file and where their values go.
#include "tools/emulator/emulator_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "shared/servo_bus/xm430.h"
#include "tools/plant/world_error.h"

namespace sanso::emulator {
namespace {

using plant::WorldError;

using files::TomlTable;

Fault read_fault(const TomlTable& table) {
  Fault fault;
  std::vector<std::string_view> kinds;
  for (const FaultKind k : all_fault_kinds()) kinds.push_back(to_string(k));
  fault.kind = all_fault_kinds()[table.need("kind", table.choice("kind", kinds),
                                            fmt::format("one of {}", fmt::join(kinds, ", ")))];
  if (const auto id = table.number("id", 0, 252)) fault.id = static_cast<int>(*id);
  if (const auto start = table.number("start_s", 0, 1e6)) fault.start = from_seconds(*start);
  if (const auto stop = table.number("stop_s", 0, 1e6)) fault.stop = from_seconds(*stop);
  TomlTable::into(fault.probability, table.number("probability", 0, 1));
  TomlTable::into(fault.amount, table.number("amount", 0, 1e6));
  table.finish("kind, id, start_s, stop_s, probability or amount");
  return fault;
}

std::int64_t read_baud(const TomlTable& table, std::int64_t otherwise) {
  const auto given = table.number("baud", 9600, 4.5e6);
  if (!given) return otherwise;
  const auto baud = static_cast<std::int64_t>(*given);
  const auto& rates = servo_bus::xm430::kBaudRates;
  if (std::find(rates.begin(), rates.end(), baud) == rates.end())
    table.fail("baud", "unknown rate", files::toml_number(*given),
               "a rate that the servo knows: 57600, 115200, 1, 2, 3, 4 or 4.5 million");
  return baud;
}

ServoSetup read_servo(const TomlTable& table) {
  ServoSetup servo;
  const auto whole = [&](const char* key, int& value, int low, int high) {
    if (const auto given = table.integer(key, low, high)) value = static_cast<int>(*given);
  };
  servo.id = static_cast<int>(table.need("id", table.integer("id", 1, kNumServos), "an id"));
  servo.baud = read_baud(table, servo.baud);
  whole("return_delay", servo.return_delay_raw, 0, 254);
  whole("firmware", servo.firmware, 1, 255);
  TomlTable::into(servo.shut_down, table.boolean("shut_down"));
  TomlTable::into(servo.horn_error_rad, table.number("horn_error_rad", -0.3, 0.3));
  table.finish("id, baud, return_delay, firmware, shut_down or horn_error_rad");
  return servo;
}

EmulatorConfig read_config(const TomlTable& table) {
  EmulatorConfig config;
  TomlTable::into(config.world, table.string("world"));
  if (const auto seed = table.number("seed", 0, 1e15))
    config.seed = static_cast<std::uint64_t>(*seed);
  TomlTable::into(config.directory, table.string("directory"));
  config.baud = read_baud(table, config.baud);
  TomlTable::into(config.hid_imu, table.boolean("hid_imu"));
  TomlTable::into(config.usb, table.boolean("usb"));
  for (const TomlTable& servo : table.tables("servo")) config.servos.push_back(read_servo(servo));
  for (const TomlTable& fault : table.tables("fault")) config.faults.push_back(read_fault(fault));
  table.finish("world, seed, directory, baud, hid_imu, usb, [[servo]] or [[fault]]");
  return config;
}

}  // namespace

EmulatorConfig load_emulator_config(const std::string& path) {
  try {
    return read_config(TomlTable::read(path));
  } catch (const files::InputError& error) {
    throw WorldError(error.what());
  }
}

}  // namespace sanso::emulator
