#include "host/motion/toml_table.h"

#include <cmath>

#include "host/motion/motion.h"
#include "shared/base/toml_grammar.h"

namespace sanso::motion {

toml::table parse_toml(const std::string& text, const std::string& file) {
  if (const auto defect = first_toml_defect(text))
    throw MotionError(file + ":" + describe(*defect));
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw MotionError(file + ":" + std::to_string(error.source().begin.line) + ": " +
                      std::string(error.description()));
  }
}

void TomlTable::fail(const std::string& key, const std::string& what) const {
  const toml::node* node = table_.get(key);
  const auto line = (node ? node->source() : table_.source()).begin.line;
  throw MotionError(file_ + ":" + std::to_string(line) + ": " + full(key) + ": " + what);
}

const toml::node* TomlTable::find(const std::string& key) {
  seen_.insert(key);
  return table_.get(key);
}

const toml::node& TomlTable::require(const std::string& key, const char* expected) {
  const toml::node* node = find(key);
  if (!node) fail(key, std::string("missing, expected ") + expected);
  return *node;
}

std::string TomlTable::text(const std::string& key) {
  const auto value = require(key, "a text").value_exact<std::string>();
  if (!value) fail(key, "is not a text");
  return *value;
}

double TomlTable::number(const std::string& key, double low, double high) {
  const auto value = require(key, "a number").value<double>();
  if (!value || !(*value >= low && *value <= high)) {
    fail(key, "expected a number from " + std::to_string(low) + " to " + std::to_string(high));
  }
  return *value;
}

std::optional<double> TomlTable::optional_number(const std::string& key) {
  const toml::node* node = find(key);
  if (!node) return {};
  const auto value = node->value<double>();
  if (!value || !std::isfinite(*value)) fail(key, "is not a number");
  return value;
}

std::vector<double> TomlTable::numbers(const std::string& key, std::size_t count) {
  const toml::array* array = require(key, "a list of numbers").as_array();
  if (!array || array->size() != count) {
    fail(key, "expected a list of " + std::to_string(count) + " numbers, found " +
                  (array ? std::to_string(array->size()) : "none"));
  }
  std::vector<double> values;
  for (const toml::node& node : *array) {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value)) fail(key, "holds something that is not a number");
    values.push_back(*value);
  }
  return values;
}

TomlTable TomlTable::table(const std::string& key) {
  const toml::table* found = require(key, "a table").as_table();
  if (!found) fail(key, "is not a table");
  return {*found, file_, full(key)};
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) {
  const toml::array* array = require(key, "a list of tables ([[...]])").as_array();
  if (!array) fail(key, "is not a list of tables ([[...]])");
  std::vector<TomlTable> found;
  for (const toml::node& node : *array) {
    if (!node.is_table()) fail(key, "holds something that is not a table");
    found.emplace_back(*node.as_table(), file_, full(key));
  }
  return found;
}

void TomlTable::optional(const std::string& key, double& value) {
  if (const auto given = optional_number(key)) value = *given;
}

void TomlTable::optional(const std::string& key, int& value) {
  const auto given = optional_number(key);
  if (given && *given != std::floor(*given)) fail(key, "is not a whole number");
  if (given) value = static_cast<int>(*given);
}

void TomlTable::optional(const std::string& key, bool& value) {
  const toml::node* node = find(key);
  if (!node) return;
  if (!node->is_boolean()) fail(key, "is neither true nor false");
  value = *node->value<bool>();
}

void TomlTable::optional(const std::string& key, std::string& value) {
  if (find(key)) value = text(key);
}

void TomlTable::finish() {
  for (const auto& [key, node] : table_) {
    if (!seen_.contains(std::string(key.str())))
      fail(std::string(key.str()), "unknown key; remove it or mend its name");
  }
}

}  // namespace sanso::motion
