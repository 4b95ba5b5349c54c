// A recursive-descent check of TOML's grammar, at most 16 levels deep; it builds nothing and
// stops at the first byte that does not belong.
#include "shared/files/toml_grammar.h"

#include <cstddef>
#include <cstdint>

namespace sanso::files {
namespace {

constexpr int kMaxDepth = 16;
constexpr char kEnd = '\0';  // also what a NUL byte in the text reads as; no rule accepts either

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_bare_key(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-';
}
int hex_value(char c) {
  if (is_digit(c)) return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}
bool is_unicode_scalar(std::uint32_t code) {
  return code <= 0x10ffff && !(code >= 0xd800 && code <= 0xdfff);
}

/// Recursive descent, one function for each rule of the grammar. A rule returns false when it does
/// not hold; the first to fail has written the defect.
class Grammar {
 public:
  explicit Grammar(std::string_view text) : text_(text) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
  }

  std::optional<TomlDefect> check() {
    while (at_ < text_.size()) {
      if (!line()) return defect_;
    }
    return std::nullopt;
  }

 private:
  char look(std::size_t ahead = 0) const {
    return at_ + ahead < text_.size() ? text_[at_ + ahead] : kEnd;
  }
  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  bool take(std::string_view word) {
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }
  bool refuse(const char* expected) {
    defect_ = TomlDefect{line_, text_.substr(at_, 20), expected};
    return false;
  }
  bool need(char c, const char* expected) { return take(c) || refuse(expected); }
  void blanks() {
    while (look() == ' ' || look() == '\t') ++at_;
  }

  bool line() {
    blanks();
    if (look() == '[') {
      if (!header()) return false;
    } else if (look() != '#' && look() != '\r' && look() != '\n' && at_ < text_.size()) {
      if (!key_value(0)) return false;
    }
    return line_end();
  }

  /// Blanks, a comment, and the end of the line or of the text.
  bool line_end() {
    blanks();
    if (!comment()) return false;
    if (at_ == text_.size() || newline()) return true;
    return refuse("the end of the line");
  }
  bool comment() {
    if (!take('#')) return true;
    while (at_ < text_.size() && look() != '\n' && !(look() == '\r' && look(1) == '\n')) {
      if (!character()) return false;
    }
    return true;
  }
  bool newline() {
    if (!take("\r\n") && !take('\n')) return false;
    ++line_;
    return true;
  }

  bool header() {
    const bool list = take("[[");
    if (!list) take('[');
    blanks();
    if (!key()) return false;
    return list ? take("]]") || refuse("]]") : need(']', "]");
  }

  bool key_value(int depth) {
    if (!key()) return false;
    if (!need('=', "=")) return false;
    blanks();
    return value(depth);
  }

  /// Ends behind the blanks that follow the key.
  bool key() {
    do {
      blanks();
      if (!key_segment()) return false;
      blanks();
    } while (take('.'));
    return true;
  }
  bool key_segment() {
    if (look() == '"' || look() == '\'') return string();
    if (!is_bare_key(look()))
      return refuse("a name (quotes around text beyond letters, digits, _ and -)");
    while (is_bare_key(look())) ++at_;
    return true;
  }

  bool value(int depth) {
    if (depth > kMaxDepth) return refuse("less deeply nested values");
    if (look() == '"' || look() == '\'') return string();
    if (look() == '[') return array(depth);
    if (look() == '{') return inline_table(depth);
    if (take("true") || take("false")) return true;
    return number();
  }

  bool number() {
    if (look() == '+' || look() == '-') ++at_;
    if (take("inf") || take("nan")) return true;
    if (look() == '0' && is_digit(look(1))) return refuse("a number without leading zeros");
    if (!digits()) return refuse("a value");
    if (take('.') && !digits()) return refuse("digits after the point");
    if (take('e') || take('E')) {
      if (look() == '+' || look() == '-') ++at_;
      if (!digits()) return refuse("digits of the exponent");
    }
    return true;
  }
  /// One or more digits; single underscores between them.
  bool digits() {
    if (!is_digit(look())) return false;
    while (is_digit(look()) || (look() == '_' && is_digit(look(1)))) ++at_;
    return true;
  }

  bool array(int depth) {
    take('[');
    while (true) {
      if (!blank_lines()) return false;
      if (take(']')) return true;
      if (!value(depth + 1) || !blank_lines()) return false;
      if (take(']')) return true;
      if (!need(',', "a comma or the end of the list")) return false;
    }
  }
  /// Blanks, comments and ends of lines inside an array.
  bool blank_lines() {
    do {
      blanks();
      if (!comment()) return false;
    } while (newline());
    return true;
  }

  bool inline_table(int depth) {
    take('{');
    blanks();
    if (take('}')) return true;
    while (true) {
      blanks();
      if (!key_value(depth + 1)) return false;
      blanks();
      if (take('}')) return true;
      if (!need(',', "a comma or }")) return false;
    }
  }

  bool string() {
    const char quote = look();
    if (look(1) == quote && look(2) == quote)
      return refuse("text in one pair of quotes, on one line");
    ++at_;
    while (at_ < text_.size() && look() != quote) {
      if (look() == '\n' || look() == '\r') return refuse("the closing quote on the same line");
      const bool escaped = quote == '"' && look() == '\\';
      if (!(escaped ? escape() : character())) return false;
    }
    return need(quote, "the closing quote");
  }
  bool escape() {
    take('\\');
    if (look() == 'u' || look() == 'U') return unicode_escape(look() == 'u' ? 4 : 8);
    constexpr std::string_view kEscapes = "btnfr\"\\";
    if (at_ < text_.size() && kEscapes.find(look()) != std::string_view::npos) return ++at_, true;
    return refuse("\\b, \\t, \\n, \\f, \\r, \\\", \\\\ or \\u and four hexadecimal digits");
  }
  bool unicode_escape(std::size_t count) {
    std::uint32_t code = 0;
    for (std::size_t k = 1; k <= count; ++k) {
      if (hex_value(look(k)) < 0)
        return refuse("four hexadecimal digits after \\u, eight after \\U");
      code = code * 16 + static_cast<std::uint32_t>(hex_value(look(k)));
    }
    if (!is_unicode_scalar(code)) return refuse("a Unicode character");
    at_ += count + 1;
    return true;
  }

  /// One printable character or tab, in UTF-8.
  bool character() {
    const auto byte = [this](std::size_t k) { return static_cast<unsigned char>(look(k)); };
    const unsigned char first = byte(0);
    if (first < 0x80) {
      if ((first < 0x20 && first != '\t') || first == 0x7f) return refuse("no control character");
      return ++at_, true;
    }
    const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4) return refuse("UTF-8");
    std::uint32_t code = first & (0x7fu >> length);
    for (std::size_t k = 1; k < length; ++k) {
      if ((byte(k) & 0xc0) != 0x80) return refuse("UTF-8");
      code = code << 6 | (byte(k) & 0x3fu);
    }
    const std::uint32_t shortest = length == 4 ? 0x10000 : length == 3 ? 0x800 : 0x80;
    if (code < shortest || !is_unicode_scalar(code)) return refuse("UTF-8");
    at_ += length;
    return true;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  TomlDefect defect_;
};

}  // namespace

std::optional<TomlDefect> first_toml_defect(std::string_view text) { return Grammar(text).check(); }

}  // namespace sanso::files
