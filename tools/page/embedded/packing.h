// Numbers, text and bytes as the page reads them out of a report: rows of numbers in 16 bits each,
// gzip streams, base64.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sanso::page {

/// A gzip stream of the bytes. Throws std::runtime_error when zlib has no memory.
std::string gzip(std::string_view bytes);
std::string base64(std::string_view bytes);

/// Runs of rows, all of `columns` numbers: each column of a run is scaled to 16 bits over its own
/// range, each number is stored as the change to the one before.
class PackedRuns {
 public:
  explicit PackedRuns(std::size_t columns) : columns_(columns) {}
  /// `about`: JSON object, as text, that the page finds beside the run's numbers. `numbers`: row by
  /// row, a multiple of the columns, all finite.
  void add(const std::string& about, std::span<const double> numbers);
  std::size_t runs() const { return runs_.size(); }
  std::size_t bytes() const { return 2 * words_.size(); }
  /// `head` (JSON object, as text) with "columns" and "trials", the runs, in front of the numbers.
  std::string pack(const std::string& head) const;

 private:
  std::size_t columns_;
  std::vector<std::string> runs_;  // JSON objects
  std::vector<std::int16_t> words_;
};

}  // namespace sanso::page
