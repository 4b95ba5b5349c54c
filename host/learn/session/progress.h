// A progress bar with the time that is left, on one line of a terminal; plain lines when the output
// is not a terminal.
#pragma once

#include <cstdio>
#include <string>

namespace sanso::learn {

class Progress {
 public:
  /// `done_before`: steps that an earlier run finished; they do not count for the estimate of the
  /// remaining time.
  Progress(std::FILE* out, std::string label, int total, int done_before = 0);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Shows that `done` of the steps are finished, with `note` behind the bar.
  void update(int done, const std::string& note);

 private:
  std::FILE* out_;
  std::string label_;
  int total_, done_before_;
  double begin_s_;
  bool terminal_, line_open_ = false;
};

}  // namespace sanso::learn
