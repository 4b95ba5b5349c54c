// The replay of a report: the page of tools/page with stored trials in it, as markup that needs
// nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/learn/episodes/episode.h"
#include "host/learn/session/session_state.h"

namespace sanso::report {

/// What is stored of one instant: base position, quaternion, joint angles; the same of the
/// reference; load of right and left foot; rms of the layers' parts; update time.
inline constexpr std::size_t kReplayColumns = 19 + 19 + 2 + 3 + 1;
using ReplayRow = std::array<double, kReplayColumns>;

/// One row every `stride` ticks; a tick that was lost shows the one before it.
std::vector<ReplayRow> replay_rows(const learn::Episode& episode, int stride);

/// Trials, packed: a JSON head that says how to read them, then numbers of 16 bits, each the change
/// to the one before.
class ReplayData {
 public:
  /// `scene`: JSON object of tools/page/scene.h, as text.
  ReplayData(std::string scene, int stride);
  void add(const learn::TrialSummary& summary, const learn::Episode& episode);
  /// `first` and `second` (-1: none) are shown at the beginning: places in the order of add().
  std::string pack(int first, int second) const;
  int trials() const { return static_cast<int>(trials_.size()); }

 private:
  std::string scene_;
  int stride_;
  std::vector<std::string> trials_;  // JSON objects
  std::vector<std::int16_t> words_;
};

/// The replay of a session's folder: first and best trial side by side, all others to choose, or as
/// many, evenly spaced, as fit into `most_bytes` of markup. Empty when the page was not built.
std::string replay_markup(const std::filesystem::path& folder, const learn::SessionState& state,
                          std::size_t most_bytes = 3'500'000);

}  // namespace sanso::report
