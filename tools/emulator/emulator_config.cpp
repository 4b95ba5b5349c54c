// The keys of the configuration file and where their values go.
#include "tools/emulator/emulator_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#define TOML_HEADER_ONLY 0
#include <toml++/toml.h>

#include "shared/base/toml_grammar.h"
#include "shared/servo_bus/xm430.h"
#include "tools/plant/world_error.h"

namespace sanso::emulator {
namespace {

using plant::WorldError;

struct Reader {
  const std::string& path;

  [[noreturn]] void refuse(const toml::node& node, const std::string& key,
                           const std::string& expected) const {
    throw WorldError(
        fmt::format("{}:{}: {}: expected {}", path, node.source().begin.line, key, expected));
  }
  double number(const toml::node& node, const std::string& key, double low, double high) const {
    const auto value = node.value<double>();
    if (!value || !(*value >= low && *value <= high))
      refuse(node, key, fmt::format("a number in [{}, {}]", low, high));
    return *value;
  }
  std::string text(const toml::node& node, const std::string& key) const {
    const auto value = node.value<std::string>();
    if (!value) refuse(node, key, "a text");
    return *value;
  }
};

Fault read_fault(const Reader& reader, const toml::table& table) {
  Fault fault;
  bool named = false;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (name == "kind") {
      const auto kind = fault_from_string(reader.text(node, "fault.kind"));
      if (!kind) {
        std::string known;
        for (const FaultKind k : all_fault_kinds())
          known += fmt::format("{}{}", known.empty() ? "" : ", ", to_string(k));
        reader.refuse(node, "fault.kind", "one of " + known);
      }
      fault.kind = *kind;
      named = true;
    } else if (name == "id") {
      fault.id = static_cast<int>(reader.number(node, "fault.id", 0, 252));
    } else if (name == "start_s") {
      fault.start = from_seconds(reader.number(node, "fault.start_s", 0, 1e6));
    } else if (name == "stop_s") {
      fault.stop = from_seconds(reader.number(node, "fault.stop_s", 0, 1e6));
    } else if (name == "probability") {
      fault.probability = reader.number(node, "fault.probability", 0, 1);
    } else if (name == "amount") {
      fault.amount = reader.number(node, "fault.amount", 0, 1e6);
    } else {
      reader.refuse(node, "fault." + name, "kind, id, start_s, stop_s, probability or amount");
    }
  }
  if (!named) reader.refuse(table, "fault", "a kind");
  return fault;
}

}  // namespace

EmulatorConfig load_emulator_config(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(in), {}};
  if (!in)
    throw WorldError(path + ": cannot be read, expected a readable file of emulator settings");
  if (const auto defect = first_toml_defect(content))
    throw WorldError(path + ":" + describe(*defect));
  toml::table table;
  try {
    table = toml::parse(content, path);
  } catch (const toml::parse_error& error) {
    throw WorldError(
        fmt::format("{}:{}: {}", path, error.source().begin.line, error.description()));
  }
  const Reader reader{path};
  EmulatorConfig config;
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (name == "world") {
      config.world = reader.text(node, name);
    } else if (name == "seed") {
      config.seed = static_cast<std::uint64_t>(reader.number(node, name, 0, 1e15));
    } else if (name == "directory") {
      config.directory = reader.text(node, name);
    } else if (name == "baud") {
      config.baud = static_cast<std::int64_t>(reader.number(node, name, 9600, 4.5e6));
      const auto& rates = servo_bus::xm430::kBaudRates;
      if (std::find(rates.begin(), rates.end(), config.baud) == rates.end()) {
        reader.refuse(node, name,
                      "a rate that the servo knows: 57600, 115200, 1, 2, 3, 4 or 4.5 million");
      }
    } else if (name == "fault") {
      const toml::array* faults = node.as_array();
      if (!faults) reader.refuse(node, name, "[[fault]] tables");
      for (const auto& entry : *faults) {
        const toml::table* inner = entry.as_table();
        if (!inner) reader.refuse(entry, name, "[[fault]] tables");
        config.faults.push_back(read_fault(reader, *inner));
      }
    } else {
      reader.refuse(node, name, "world, seed, directory, baud or [[fault]]");
    }
  }
  return config;
}

}  // namespace sanso::emulator
