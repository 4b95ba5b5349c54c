// What went wrong in a file a person gave us: which file, which line, what stood there, what was
// expected, what to do next.
#pragma once

#include <stdexcept>
#include <string>

namespace sanso::files {

/// Thrown by every reader of user files. `defect` is a short stable name ("empty file", "not a
/// number", ...) that verdict.json and tests may rely on; `line` counts from 1, 0 = the file as a
/// whole.
struct InputError : std::runtime_error {
  InputError(std::string file_, int line_, std::string channel_, std::string defect_,
             std::string value_, std::string expected_)
      : std::runtime_error(text(file_, line_, channel_, defect_, value_, expected_)),
        file(std::move(file_)),
        line(line_),
        channel(std::move(channel_)),
        defect(std::move(defect_)),
        value(std::move(value_)),
        expected(std::move(expected_)) {}

  std::string file;
  int line;
  std::string channel;  // column or key, empty when the whole line or file is meant
  std::string defect;
  std::string value;     // what stood there, shortened
  std::string expected;  // what should stand there, or the next step

 private:
  static std::string text(const std::string& file, int line, const std::string& channel,
                          const std::string& defect, const std::string& value,
                          const std::string& expected) {
    std::string s = file;
    if (line > 0) s += ":" + std::to_string(line);
    s += ": " + defect;
    if (!channel.empty()) s += " in '" + channel + "'";
    if (!value.empty()) s += ": found '" + value + "'";
    if (!expected.empty()) s += "; expected " + expected;
    return s;
  }
};

}  // namespace sanso::files
