// Strict access to a TOML table: every read names the key, its line and what was expected; keys
// nobody asked for are errors. The one place that touches the TOML library, so that a malformed
// file is always an InputError.
#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sanso::recording {

/// A table inside a parsed document. Copies are cheap and keep the document alive.
class TomlTable {
 public:
  static TomlTable parse(std::string_view text, const std::string& file);
  static TomlTable read(const std::string& path);

  const std::string& file() const;
  const std::string& path() const { return path_; }  // "joint.l_knee"; empty at the top
  int line() const;
  int line_of(std::string_view key) const;
  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;  // in alphabetical order

  std::optional<double> number(std::string_view key, double low, double high) const;
  std::optional<long> integer(std::string_view key) const;
  std::optional<std::string> string(std::string_view key) const;
  std::optional<std::vector<double>> numbers(std::string_view key, std::size_t count) const;
  std::optional<std::vector<std::string>> strings(std::string_view key) const;
  std::optional<TomlTable> table(std::string_view key) const;
  std::vector<TomlTable> tables(std::string_view key) const;  // [[key]]

  /// Throws when the table holds a key that is not in `known`.
  void allow_only(std::initializer_list<std::string_view> known) const;
  void allow_only(const std::vector<std::string_view>& known) const;
  [[noreturn]] void fail(std::string_view key, std::string defect, std::string value,
                         std::string expected) const;

 private:
  struct Node;
  explicit TomlTable(std::shared_ptr<const Node> node, std::string path)
      : node_(std::move(node)), path_(std::move(path)) {}
  std::shared_ptr<const Node> node_;
  std::string path_;
};

/// A string with quotes and escapes as TOML wants it.
std::string toml_quoted(std::string_view text);
/// A key: bare where TOML allows it, else quoted.
std::string toml_key(std::string_view text);
/// Shortest text that reads back to the same number, always with a point or exponent ("12.0"),
/// "inf" for infinity.
std::string toml_number(double value);

}  // namespace sanso::recording
