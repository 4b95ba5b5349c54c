// The part of TOML that every settings file of the project is written in, checked before the TOML
// library (3.x) parses the text: the library aborts on, or reads beyond, some malformed texts
// instead of refusing them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sanso::files {

struct TomlDefect {
  int line = 0;  // from 1
  // at most 20 bytes of the text, where it stopped making sense; empty at its end
  std::string_view found;
  const char* expected = "";
};

/// The first thing in `text` outside the accepted part of TOML 1.0; nothing when the text may be
/// parsed. Accepted:
/// [table], [[table]], key = value with dotted and quoted keys, single-line strings, decimal
/// integers and floats, inf, nan, booleans, arrays over several lines, inline tables; nested at
/// most 16 deep. Not accepted: multi-line strings, dates, other number bases. What needs the whole
/// document (a key given twice) is left to the library.
std::optional<TomlDefect> first_toml_defect(std::string_view text);

}  // namespace sanso::files
