// Checks the grammar, parses, then asks for the settings key by key; an error names file, line
// and key.
#include "firmware/config/program_config.h"

#include <fstream>
#include <set>
#include <sstream>
#include <type_traits>

#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

#include "shared/base/toml_grammar.h"

namespace sanso::firmware {
namespace {

/// Reads one table key by key and remembers which keys were known.
class TableReader {
 public:
  TableReader(const toml::table* table, std::string name, std::string file, std::string& error)
      : table_(table), name_(std::move(name)), file_(std::move(file)), error_(error) {}

  void read(const char* key, std::string& value) {
    if (const toml::node* node = find(key)) {
      if (const auto v = node->value_exact<std::string>())
        value = *v;
      else
        fail(*node, key, "a text");
    }
  }
  template <class T>
  void read(const char* key, T& value, T low, T high) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    std::optional<T> v;
    if constexpr (std::is_same_v<T, bool>) {
      v = node->value_exact<bool>();
      if (!v) return fail(*node, key, "true or false");
    } else {
      if (std::is_same_v<T, double> || node->is_integer()) v = node->value<T>();
      std::ostringstream range;
      range << (std::is_same_v<T, int> ? "a whole number" : "a number") << " from " << low << " to "
            << high;
      if (!v || !(*v >= low && *v <= high)) return fail(*node, key, range.str());
    }
    value = *v;
  }
  void reject_unknown() {
    if (table_ == nullptr) return;
    for (const auto& [key, node] : *table_)
      if (!known_.contains(std::string(key.str())))
        fail(node, std::string(key.str()), "no such setting; docs/settings.md lists them");
  }

 private:
  const toml::node* find(const char* key) {
    known_.insert(key);
    return table_ != nullptr ? table_->get(key) : nullptr;
  }
  void fail(const toml::node& node, const std::string& key, const std::string& expected) {
    if (!error_.empty()) return;
    std::ostringstream text;
    text << file_ << ":" << node.source().begin.line << ": " << name_ << "." << key << " = ";
    if (node.is_value())
      node.visit([&](const auto& n) { text << n; });
    else  // the library's own text of a list casts a negative width to unsigned
      text << (node.is_array() ? "a list" : "a table");
    text << ": expected " << expected;
    error_ = text.str();
  }
  const toml::table* table_;
  std::string name_, file_;
  std::string& error_;
  std::set<std::string> known_;
};

void read_devices(TableReader reader, DeviceConfig& device) {
  reader.read("bus", device.bus);
  reader.read("imu", device.imu);
  reader.read("pose", device.pose);
  reader.read("listen", device.listen);
  reader.read("port", device.port, 0, 65535);
  reader.read("key_file", device.key_file);
  reader.read("log_directory", device.log_directory);
  reader.read("tick_priority", device.tick_priority, 1, 99);
  reader.reject_unknown();
}

}  // namespace

bool parse_program_config(const std::string& text, const std::string& name, ProgramConfig& config,
                          std::string& error) {
  error.clear();
  if (const auto defect = first_toml_defect(text)) {
    error = name + ":" + describe(*defect);
    return false;
  }
  const toml::parse_result parsed = toml::parse(text, name);
  if (!parsed) {
    std::ostringstream message;
    message << name << ":" << parsed.error().source().begin.line << ": "
            << parsed.error().description();
    error = message.str();
    return false;
  }
  const toml::table& root = parsed.table();
  std::set<std::string> sections{"device"};
  read_devices({root["device"].as_table(), "device", name, error}, config.device);
  config.settings.visit([&](const char* section, auto& group) {
    sections.insert(section);
    TableReader reader(root[section].as_table(), section, name, error);
    group.visit([&](const char* key, auto& value, auto low, auto high, const char*) {
      reader.read(key, value, low, high);
    });
    reader.reject_unknown();
  });
  for (const auto& [key, node] : root) {
    if (error.empty() && (!sections.contains(std::string(key.str())) || !node.is_table()))
      error = name + ":" + std::to_string(node.source().begin.line) + ": [" +
              std::string(key.str()) + "]: no such section; docs/settings.md lists them";
  }
  return error.empty();
}

bool read_program_config(const std::string& path, ProgramConfig& config, std::string& error) {
  std::ifstream file(path);
  if (!file) {
    error = path + ": cannot be read";
    return false;
  }
  std::ostringstream text;
  text << file.rdbuf();
  return parse_program_config(text.str(), path, config, error);
}

}  // namespace sanso::firmware
