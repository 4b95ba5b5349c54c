// The replay of a report: the page of tools/page with stored trials in it, as markup that needs
// nothing else; and the page that makes a film of two of them.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/learn/episodes/episode.h"
#include "host/learn/session/session_state.h"
#include "tools/page/embedded/packing.h"

namespace sanso::report {

/// What is stored of one instant: base position, quaternion, joint angles; the same of the
/// reference; load of right and left foot; rms of the layers' parts; update time.
inline constexpr std::size_t kReplayColumns = 19 + 19 + 2 + 3 + 1;
using ReplayRow = std::array<double, kReplayColumns>;

/// One row every `stride` ticks; a tick that was lost shows the one before it.
std::vector<ReplayRow> replay_rows(const learn::Episode& episode, int stride);

/// Trials, packed: a JSON head that says how to read them, then their rows.
class ReplayData {
 public:
  /// `scene`: JSON object of tools/page/scene.h, as text.
  ReplayData(std::string scene, int stride);
  void add(const learn::TrialSummary& summary, const learn::Episode& episode);
  /// `first` and `second` (-1: none) are shown at the beginning: places in the order of add().
  std::string pack(int first, int second) const;
  int trials() const { return static_cast<int>(runs_.runs()); }

 private:
  std::string scene_;
  int stride_;
  page::PackedRuns runs_{kReplayColumns};
};

/// The replay of a session's folder: first and best trial side by side, all others to choose, or as
/// many, evenly spaced, as fit into `most_bytes` of markup. Empty when the page was not built.
std::string replay_markup(const std::filesystem::path& folder, const learn::SessionState& state,
                          std::size_t most_bytes = 3'500'000);

/// The same view of a motion that nobody has tried yet: its reference at every tick. Empty when the
/// page was not built.
std::string preview_markup(const std::vector<model::State>& reference);

struct FilmOptions {
  std::string kind;           // "png", "gif" or "webm"
  int first = 0, second = 0;  // numbers of trials, from 1; 0: the first, the last
  int width_px = 640, row_height_px = 300;
  double fps = 25;
  double from_s = 0, to_s = 0;  // of the trial; to 0: the end
};

/// A page that draws two trials, the first above the second, and sends what it has drawn to the
/// server that it came from. Throws std::runtime_error when there are no such trials.
std::string film_page(const std::filesystem::path& folder, const learn::SessionState& state,
                      const FilmOptions& options);

}  // namespace sanso::report
