// Splits by hand, row by row; from_chars reads the numbers, so the locale does not matter.
#include "tools/recording/csv_reader.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>

#include "shared/files/input_error.h"
#include "tools/recording/reading_error.h"
#include "tools/recording/sidecar.h"

namespace sanso::recording {
namespace {

std::string shortened(std::string_view s) {
  return std::string(s.substr(0, 40)) + (s.size() > 40 ? "..." : "");
}

std::string_view trimmed(std::string_view s) {
  const auto first = s.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t\r") - first + 1);
}

/// Turns lines into a Recording, one call a line.
class CsvParser {
 public:
  CsvParser(std::string file, const CsvLimits& limits) : limits_(limits) {
    recording_.file = std::move(file);
  }

  void line(std::string_view text) {
    ++line_;
    // byte order mark
    if (line_ == 1 && text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);
    text = trimmed(text);
    if (text.empty()) {
      if (blank_line_ == 0 && have_header_) blank_line_ = line_;
      return;
    }
    if (blank_line_ != 0)
      fail(blank_line_, "", "blank line", "", "a row of values, or the end of the file");
    have_header_ ? row(text) : header(text);
  }

  Recording finish() {
    if (!have_header_) fail(0, "", "empty file", "", "a header line such as t,q:knee,u:knee");
    if (recording_.rows() == 0)
      fail(0, "", "header only", "", "at least one row of values below the header");
    return std::move(recording_);
  }

 private:
  [[noreturn]] void fail(int line, std::string channel, std::string defect, std::string_view value,
                         std::string expected) const {
    throw files::InputError(recording_.file, line, std::move(channel), std::move(defect),
                            shortened(value), std::move(expected));
  }

  [[noreturn]] void fail(ReadFault fault, int line, std::string channel, std::string defect,
                         std::string_view value, std::string expected) const {
    throw ReadingError(fault, recording_.file, line, std::move(channel), std::move(defect),
                       shortened(value), std::move(expected));
  }

  void header(std::string_view text) {
    have_header_ = true;
    recording_.header_line = line_;
    if (text.find(',') == std::string_view::npos &&
        text.find_first_of(";\t") != std::string_view::npos) {
      fail(line_, "", "wrong separator", text, "columns separated by commas");
    }
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t comma = std::min(text.find(',', begin), text.size());
      column(trimmed(text.substr(begin, comma - begin)));
      begin = comma + 1;
    }
    if (time_column_ < 0)
      fail(ReadFault::missing_channel, line_, "t", "no time column", text,
           "a column named t, in seconds");
  }

  void column(std::string_view name) {
    if (target_.size() >= limits_.max_columns)
      fail(line_, "", "too many columns", name, "at most " + std::to_string(limits_.max_columns));
    if (name.empty()) fail(line_, "", "column without a name", "", "a name such as q:knee");
    if (std::find(names_.begin(), names_.end(), name) != names_.end()) {
      fail(line_, std::string(name), "column given twice", name, "every column once");
    }
    double number = 0.0;
    if (std::from_chars(name.data(), name.data() + name.size(), number).ec == std::errc{}) {
      fail(line_, "", "no header", name, "column names in the first line");
    }
    names_.emplace_back(name);
    if (name == "t") {
      time_column_ = static_cast<int>(target_.size());
      target_.push_back(kTime);
    } else if (kind_of(name) != nullptr) {
      target_.push_back(static_cast<int>(recording_.channels.size()));
      recording_.channels.push_back({std::string(name), {}});
    } else {
      target_.push_back(kIgnore);
      recording_.ignored.emplace_back(name);
    }
  }

  void row(std::string_view text) {
    values_ += recording_.channels.size() + 1;
    if (values_ > limits_.max_values) {
      fail(ReadFault::too_large, line_, "", "recording too large",
           std::to_string(recording_.rows()) + " rows",
           "at most " + std::to_string(limits_.max_values) +
               " values; cut it into shorter recordings");
    }
    std::size_t k = 0;
    for (std::size_t begin = 0; begin <= text.size(); ++k) {
      const std::size_t comma = std::min(text.find(',', begin), text.size());
      if (k < target_.size()) cell(k, trimmed(text.substr(begin, comma - begin)));
      begin = comma + 1;
    }
    if (k != target_.size()) {
      fail(line_, "", "wrong number of cells", std::to_string(k),
           std::to_string(target_.size()) + " as in the header");
    }
  }

  void cell(std::size_t k, std::string_view text) {
    if (target_[k] == kIgnore) return;
    const double value = text.empty() ? std::numeric_limits<double>::quiet_NaN() : number(k, text);
    if (target_[k] == kTime) {
      if (text.empty())
        fail(ReadFault::not_a_number, line_, "t", "time missing", "", "seconds in every row");
      recording_.t.push_back(value);
    } else {
      recording_.channels[static_cast<std::size_t>(target_[k])].values.push_back(value);
    }
  }

  double number(std::size_t k, std::string_view text) const {
    std::string_view digits = text;
    if (digits.front() == '+') digits.remove_prefix(1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc::result_out_of_range) {
      fail(line_, names_[k], "number out of range", text, "a magnitude between 1e-308 and 1e308");
    }
    if (error != std::errc{} || end != digits.data() + digits.size()) {
      fail(line_, names_[k], "not a number", text,
           "a decimal number, or nothing when it was not sampled");
    }
    if (!std::isfinite(value)) {
      fail(ReadFault::not_a_number, line_, names_[k], "NaN or infinity", text,
           "a finite number, or nothing when it was not sampled");
    }
    return value;
  }

  static constexpr int kTime = -1;
  static constexpr int kIgnore = -2;
  CsvLimits limits_;
  Recording recording_;
  std::vector<std::string> names_;  // every column of the header
  std::vector<int> target_;         // column -> channel index, kTime or kIgnore
  std::size_t values_ = 0;
  int line_ = 0;
  int blank_line_ = 0;
  int time_column_ = -1;
  bool have_header_ = false;
};

std::string sidecar_path(const std::string& path) {
  std::filesystem::path p = path;
  if (p.extension() == ".gz") p.replace_extension();
  return p.replace_extension(".toml").string();
}

}  // namespace

Recording parse_csv(std::string_view text, const std::string& name, const CsvLimits& limits) {
  CsvParser parser(name, limits);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end - begin > limits.max_line_bytes)
      throw files::InputError(name, 0, "", "line too long", "", "text lines");
    parser.line(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parser.finish();
}

Recording read_csv(const std::string& path, const CsvLimits& limits) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw files::InputError(path, 0, "", "is a folder", "",
                            "a file ending in .csv, .csv.gz or .mcap");
  }
  // zlib reads plain text unchanged and unpacks gzip: one path for both
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
  if (!file)
    throw ReadingError(ReadFault::unreadable, path, 0, "", "cannot open", std::strerror(errno),
                       "a readable file");
  gzbuffer(file.get(), 1 << 17);

  CsvParser parser(path, limits);
  std::string pending;  // the unfinished last line of the block before
  std::vector<char> block(1 << 16);
  int line = 1;
  for (;;) {
    const int n = gzread(file.get(), block.data(), static_cast<unsigned>(block.size()));
    if (n < 0) {
      int code = 0;
      throw files::InputError(path, line, "", "damaged gzip file", gzerror(file.get(), &code),
                              "an intact file");
    }
    if (n == 0) break;
    std::string_view rest(block.data(), static_cast<std::size_t>(n));
    if (rest.find('\0') != std::string_view::npos) {
      throw ReadingError(ReadFault::unreadable, path, line, "", "binary data", "",
                         "CSV text (plain or gzip)");
    }
    for (std::size_t end; (end = rest.find('\n')) != std::string_view::npos;
         rest.remove_prefix(end + 1), ++line) {
      pending.append(rest.substr(0, end));
      parser.line(pending);
      pending.clear();
    }
    pending.append(rest);
    if (pending.size() > limits.max_line_bytes)
      throw files::InputError(path, line, "", "line too long", "", "text lines");
  }
  int code = Z_OK;
  gzerror(file.get(), &code);
  if (code != Z_OK && code != Z_STREAM_END)
    throw files::InputError(path, line, "", "truncated gzip file", "", "an intact file");
  if (!pending.empty()) parser.line(pending);

  Recording recording = parser.finish();
  if (const std::string sidecar = sidecar_path(path); std::filesystem::exists(sidecar, error)) {
    read_sidecar(sidecar, recording);
  }
  return recording;
}

}  // namespace sanso::recording
