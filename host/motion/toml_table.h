// Strict reading of TOML tables: every key is asked for once, what is left over is an error that
// names it.
#pragma once

#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sanso::motion {

/// Throws MotionError with file and line on a syntax error.
toml::table parse_toml(const std::string& text, const std::string& file);

class TomlTable {
 public:
  /// `path`: of the table in the file, for messages. The table must outlive the reader.
  TomlTable(const toml::table& table, std::string file, std::string path)
      : table_(table), file_(std::move(file)), path_(std::move(path)) {}

  std::string text(const std::string& key);
  double number(const std::string& key, double low, double high);
  std::optional<double> optional_number(const std::string& key);
  std::vector<double> numbers(const std::string& key, std::size_t count);
  TomlTable table(const std::string& key);
  std::vector<TomlTable> tables(const std::string& key);

  /// Leaves `value` alone when the key is missing.
  void optional(const std::string& key, double& value);
  void optional(const std::string& key, int& value);
  void optional(const std::string& key, bool& value);
  void optional(const std::string& key, std::string& value);

  /// Throws when a key was never asked for.
  void finish();
  [[noreturn]] void fail(const std::string& key, const std::string& what) const;

 private:
  const toml::node* find(const std::string& key);
  const toml::node& require(const std::string& key, const char* expected);
  std::string full(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }

  const toml::table& table_;
  std::string file_, path_;
  std::set<std::string> seen_;
};

}  // namespace sanso::motion
