// Rewrites one line with a carriage return when the output is a terminal, and prints a line a
// step otherwise.
#include "host/learn/session/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>

#include "host/learn/wall_clock.h"

namespace sanso::learn {
namespace {

std::string minutes_seconds(double seconds) {
  const long s = std::lround(seconds);
  return fmt::format("{}:{:02d}", s / 60, s % 60);
}

}  // namespace

Progress::Progress(std::FILE* out, std::string label, int total, int done_before)
    : out_(out),
      label_(std::move(label)),
      total_(total),
      done_before_(done_before),
      begin_s_(wall_s()),
      terminal_(::isatty(::fileno(out)) != 0) {}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', out_);
}

void Progress::update(int done, const std::string& note) {
  const double elapsed_s = wall_s() - begin_s_;
  const int here = done - done_before_;
  const std::string left = here > 0 ? minutes_seconds(elapsed_s / here * (total_ - done)) : "-:--";
  constexpr int kWidth = 24;
  const int filled = total_ > 0 ? kWidth * done / total_ : kWidth;
  const std::string line =
      fmt::format("{} [{}{}] {}/{}  {} left  {}", label_, std::string(filled, '#'),
                  std::string(kWidth - filled, '.'), done, total_, left, note);
  if (terminal_) {
    fmt::print(out_, "\r\033[K{}", line);
    line_open_ = true;
  } else {
    fmt::print(out_, "{}\n", line);
  }
  std::fflush(out_);
}

}  // namespace sanso::learn
