// Access by key over the TOML library's tree; what is asked for is remembered, so that finish() can
// name what nobody knows.
#include "shared/files/toml.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>

#include "shared/files/input_error.h"
#include "shared/files/toml_grammar.h"

namespace sanso::files {

struct TomlTable::Node {
  std::shared_ptr<const toml::table> document;  // keeps `table` alive
  const toml::table* table;
  std::string file;
  std::set<std::string, std::less<>> asked;

  const toml::node* find(std::string_view key) {
    asked.emplace(key);
    return table->get(key);
  }
};

namespace {

constexpr std::size_t kLongest = 1'000'000;  // bytes

int line_at(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

std::string shown(const toml::node& node) {
  // the library's own text of a list casts a negative width to unsigned
  if (node.is_array()) return "a list";
  if (node.is_table()) return "a table";
  std::ostringstream out;
  node.visit([&](const auto& n) { out << n; });
  std::string s = out.str();
  if (s.size() > 40) s = s.substr(0, 40) + "...";
  return s;
}

}  // namespace

TomlTable TomlTable::parse(std::string_view text, const std::string& file) {
  if (const auto defect = first_toml_defect(text))
    throw InputError(file, defect->line, "", "not valid TOML", std::string(defect->found),
                     defect->expected);
  try {
    auto document = std::make_shared<const toml::table>(toml::parse(text, file));
    return TomlTable(std::make_shared<Node>(Node{document, document.get(), file, {}}), "");
  } catch (const toml::parse_error& e) {
    throw InputError(file, static_cast<int>(e.source().begin.line), "", "not valid TOML", "",
                     std::string(e.description()));
  }
}

TomlTable TomlTable::read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text(kLongest + 1, '\0');
  if (in) in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.gcount() == 0 && !in.eof())
    throw InputError(path, 0, "", "cannot open", "", "a readable TOML file");
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kLongest)
    throw InputError(path, 0, "", "file too large", "", "settings of at most 1 MB");
  return parse(text, path);
}

int TomlTable::line() const { return line_at(*node_->table); }
int TomlTable::line_of(std::string_view key) const {
  const toml::node* n = node_->table->get(key);
  return n == nullptr ? line() : line_at(*n);
}
bool TomlTable::has(std::string_view key) const { return node_->table->contains(key); }

std::vector<std::string> TomlTable::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : *node_->table) names.emplace_back(key.str());
  return names;
}

std::string TomlTable::full(std::string_view key) const {
  return path_.empty() ? std::string(key) : path_ + "." + std::string(key);
}

void TomlTable::fail(std::string_view key, std::string defect, std::string value,
                     std::string expected) const {
  throw InputError(node_->file, line_of(key), full(key), std::move(defect), std::move(value),
                   std::move(expected));
}

std::optional<double> TomlTable::number(std::string_view key, double low, double high) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  const std::optional<double> value = n->is_number() ? n->value<double>() : std::nullopt;
  const std::string range = "a number from " + toml_number(low) + " to " + toml_number(high);
  if (!value) fail(key, "not a number", shown(*n), range);
  if (std::isnan(*value) || *value < low || *value > high)
    fail(key, "out of range", toml_number(*value), range);
  return value;
}

std::optional<long> TomlTable::integer(std::string_view key) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  if (!n->is_integer()) fail(key, "not an integer", shown(*n), "a whole number");
  return static_cast<long>(*n->value<std::int64_t>());
}

std::optional<long> TomlTable::integer(std::string_view key, long low, long high) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  const std::string range =
      "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  if (!n->is_integer()) fail(key, "not an integer", shown(*n), range);
  const auto value = static_cast<long>(*n->value<std::int64_t>());
  if (value < low || value > high) fail(key, "out of range", std::to_string(value), range);
  return value;
}

std::optional<bool> TomlTable::boolean(std::string_view key) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  if (!n->is_boolean()) fail(key, "neither true nor false", shown(*n), "true or false");
  return n->value<bool>();
}

std::optional<std::size_t> TomlTable::choice(std::string_view key,
                                             const std::vector<std::string_view>& names) const {
  const std::optional<std::string> name = string(key);
  if (!name) return std::nullopt;
  const auto found = std::find(names.begin(), names.end(), *name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string known;
  for (const std::string_view n : names) {
    if (!known.empty()) known += " or ";
    known += toml_quoted(n);
  }
  fail(key, "unknown name", *name, known);
}

std::optional<std::string> TomlTable::string(std::string_view key) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  if (!n->is_string()) fail(key, "not a string", shown(*n), "text in quotes");
  return n->value<std::string>();
}

std::optional<std::vector<double>> TomlTable::numbers(std::string_view key,
                                                      std::size_t count) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  const std::string expected = "a list of " + std::to_string(count) + " numbers";
  const toml::array* array = n->as_array();
  if (array == nullptr || array->size() != count) fail(key, "wrong list", shown(*n), expected);
  std::vector<double> values;
  for (const toml::node& element : *array) {
    const auto value = element.is_number() ? element.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) fail(key, "wrong list", shown(*n), expected);
    values.push_back(*value);
  }
  return values;
}

std::optional<std::vector<std::string>> TomlTable::strings(std::string_view key) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  const toml::array* array = n->as_array();
  if (array == nullptr) fail(key, "wrong list", shown(*n), "a list of texts in quotes");
  std::vector<std::string> values;
  for (const toml::node& element : *array) {
    if (!element.is_string()) fail(key, "wrong list", shown(*n), "a list of texts in quotes");
    values.push_back(*element.value<std::string>());
  }
  return values;
}

std::optional<TomlTable> TomlTable::table(std::string_view key) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return std::nullopt;
  if (!n->is_table()) fail(key, "not a table", shown(*n), "a table [" + std::string(key) + "]");
  return TomlTable(std::make_shared<Node>(Node{node_->document, n->as_table(), node_->file, {}}),
                   full(key));
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) const {
  const toml::node* n = node_->find(key);
  if (n == nullptr) return {};
  const toml::array* array = n->as_array();
  if (array == nullptr)
    fail(key, "not a list of tables", shown(*n), "[[" + std::string(key) + "]]");
  std::vector<TomlTable> tables;
  for (const toml::node& element : *array) {
    if (!element.is_table())
      fail(key, "not a list of tables", shown(*n), "[[" + std::string(key) + "]]");
    tables.push_back(TomlTable(
        std::make_shared<Node>(Node{node_->document, element.as_table(), node_->file, {}}),
        full(key)));
  }
  return tables;
}

void TomlTable::allow_only(std::initializer_list<std::string_view> known) const {
  allow_only(std::vector<std::string_view>(known));
}

void TomlTable::allow_only(const std::vector<std::string_view>& known) const {
  for (const auto& [key, value] : *node_->table) {
    if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
    std::string list;
    for (std::string_view k : known) list += (list.empty() ? "" : ", ") + std::string(k);
    fail(key.str(), "unknown key", std::string(key.str()), "one of: " + list);
  }
}

void TomlTable::finish(const std::string& advice) const {
  for (const auto& [key, value] : *node_->table) {
    if (!node_->asked.contains(key.str())) fail(key.str(), "unknown key", shown(value), advice);
  }
}

std::string toml_quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      char escape[8];
      std::snprintf(escape, sizeof escape, "\\u%04X",
                    static_cast<unsigned>(static_cast<unsigned char>(c)));
      out += escape;
    } else {
      out += c;
    }
  }
  return out + '"';
}

std::string toml_key(std::string_view text) {
  const auto bare = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  };
  const bool plain = !text.empty() && std::all_of(text.begin(), text.end(), bare);
  return plain ? std::string(text) : toml_quoted(text);
}

std::string toml_number(double value) {
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  if (std::isnan(value)) return "nan";
  char buffer[32];
  std::string s(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
  if (s.find_first_of(".e") == std::string::npos) s += ".0";
  return s;
}

}  // namespace sanso::files
