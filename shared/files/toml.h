// Strict access to a TOML table: every read names the key, its line and what was expected; keys
// nobody asked for are errors. The one place that touches the TOML library, so that a malformed
// file is always an InputError.
#pragma once

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sanso::files {

/// A table inside a parsed document. Copies are cheap and keep the document alive.
class TomlTable {
 public:
  static TomlTable parse(std::string_view text, const std::string& file);
  static TomlTable read(const std::string& path);

  const std::string& path() const { return path_; }  // "joint.l_knee"; empty at the top
  int line() const;
  int line_of(std::string_view key) const;
  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;  // in alphabetical order

  // Each is empty when the key is missing, and an InputError when what stands there is something
  // else than the name says or lies outside the range.
  std::optional<double> number(std::string_view key, double low, double high) const;
  std::optional<long> integer(std::string_view key) const;
  std::optional<long> integer(std::string_view key, long low, long high) const;
  std::optional<bool> boolean(std::string_view key) const;
  std::optional<std::string> string(std::string_view key) const;
  /// Which of `names` stands there.
  std::optional<std::size_t> choice(std::string_view key,
                                    const std::vector<std::string_view>& names) const;
  std::optional<std::vector<double>> numbers(std::string_view key, std::size_t count) const;
  std::optional<std::vector<std::string>> strings(std::string_view key) const;
  std::optional<TomlTable> table(std::string_view key) const;
  std::vector<TomlTable> tables(std::string_view key) const;  // [[key]]

  /// `value`, or an InputError that says what is missing:
  /// need("mass", t.number("mass", 0, 9), "kg").
  template <class T>
  T need(std::string_view key, std::optional<T> value, std::string expected) const {
    if (!value) fail(key, "missing key", "", std::move(expected));
    return *std::move(value);
  }
  /// Leaves `value` alone when the key is missing.
  template <class T>
  static void into(T& value, const std::optional<T>& given) {
    if (given) value = *given;
  }

  /// Throws when the table holds a key that is not in `known`.
  void allow_only(std::initializer_list<std::string_view> known) const;
  void allow_only(const std::vector<std::string_view>& known) const;
  /// Throws when the table holds a key that none of the calls above has asked for.
  void finish(const std::string& advice = "no such key; remove it or mend its name") const;
  [[noreturn]] void fail(std::string_view key, std::string defect, std::string value,
                         std::string expected) const;

 private:
  struct Node;
  explicit TomlTable(std::shared_ptr<Node> node, std::string path)
      : node_(std::move(node)), path_(std::move(path)) {}
  std::string full(std::string_view key) const;
  std::shared_ptr<Node> node_;
  std::string path_;
};

/// A string with quotes and escapes as TOML wants it.
std::string toml_quoted(std::string_view text);
/// A key: bare where TOML allows it, else quoted.
std::string toml_key(std::string_view text);
/// Shortest text that reads back to the same number, always with a point or exponent ("12.0"),
/// "inf" for infinity.
std::string toml_number(double value);

}  // namespace sanso::files
