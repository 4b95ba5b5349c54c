// A recording in memory: time stamps and named channels of equal length. Columns as in
// docs/model-folder.md.
// Empty cells are NaN ("not sampled"); an empty command cell means that the actuator was off at
// that sample.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/recording/overrides.h"

namespace sanso::recording {

/// One column, for example "q:l_knee"; values.size() == Recording::rows().
struct Channel {
  std::string name;
  std::vector<double> values;  // SI units of the column's kind; NaN = not sampled
};

struct Recording {
  std::string file;                  // as the user named it; used in every message
  std::string condition;             // [recording] condition of the sidecar; empty = none given
  std::vector<double> t;             // s, as recorded (need not start at 0)
  std::vector<Channel> channels;     // in file order, without t
  std::vector<Override> overrides;   // what the sidecar sets differently from the model
  std::vector<Payload> payloads;     // bodies that the sidecar says were attached
  std::vector<std::string> ignored;  // columns of no known kind, dropped by the reader
  bool cut = false;  // the file ends too early (power lost); what is whole has been read
  // row k of the data stands in line header_line + 1 + k of a CSV without blank lines
  int header_line = 1;

  std::size_t rows() const { return t.size(); }
  /// Values of a channel, or an empty span when the recording has no such column.
  std::span<const double> find(std::string_view name) const;
  bool has(std::string_view name) const { return !find(name).empty(); }
  /// Adds a channel (or replaces the one of this name). `values` must have rows() entries.
  void set(std::string_view name, std::vector<double> values);
  /// Joints named by any column, in order of first appearance.
  std::vector<std::string> joints() const;
  /// File name without folder and extension: what reports call this recording.
  std::string stem() const;
};

/// The kind of a column: what stands before the colon, and the unit its values have.
struct ChannelKind {
  std::string_view prefix;  // "q", "base_p", ...
  std::string_view unit;
  enum class Suffix { none, joint, xyz, wxyz } suffix;
};
/// Kind of a column name, or nullptr when it is none of them ("q:" without a joint is none).
const ChannelKind* kind_of(std::string_view column);

/// Throws InputError naming the first row where time does not increase (equal stamps included) or
/// is missing.
void require_increasing_time(const Recording& recording);

}  // namespace sanso::recording
