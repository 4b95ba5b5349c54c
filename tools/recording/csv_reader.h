// Reads a recording from CSV text, plain or gzip. Strict: whatever is not a number is an error that
// names file, line, column and value. Reads row by row, so memory is bounded by `max_values`
// whatever the size of the file.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "tools/recording/recording.h"

namespace sanso::recording {

struct CsvLimits {
  // cells kept in memory (0.8 GB); a larger file is refused by name
  std::size_t max_values = 100'000'000;
  std::size_t max_line_bytes = 1'000'000;  // a line longer than this is not a recording
  std::size_t max_columns = 4096;
};

/// Reads FILE.csv or FILE.csv.gz, and the sidecar FILE.toml when there is one. Throws InputError.
Recording read_csv(const std::string& path, const CsvLimits& limits = {});

/// The same for text in memory (no sidecar); `name` is used in messages.
Recording parse_csv(std::string_view text, const std::string& name, const CsvLimits& limits = {});

}  // namespace sanso::recording
