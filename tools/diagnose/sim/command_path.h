// Clock and command path: what the servo of a joint is asked for between two instants, after delay,
// hold and loss.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/diagnose/sim/drive.h"
#include "tools/diagnose/sim/lane_state.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

class CommandPath {
 public:
  /// random_seed 0: a lost command is replaced by its expectation; otherwise losses are drawn, and
  /// when commands are taken.
  CommandPath(const SimParams& params, const Drive& drive, std::uint64_t random_seed);

  using Command = CommandOf<double>;
  /// The command of joint j that acts during [from, until], s. `cursor`: the caller's place in the
  /// series; it begins as kUnset, and later calls with it go forward in time.
  Command over(std::size_t j, double from, double until, std::size_t& cursor) const;
  static constexpr std::size_t kUnset = static_cast<std::size_t>(-1);
  /// Joint j's commands by row, after hold and loss, before the delay; null: it has none.
  const double* series(std::size_t j) const {
    const std::vector<double>* s = series_[j];
    return s == nullptr ? nullptr : s->data();
  }

 private:
  const std::vector<double>& t_;
  std::vector<const std::vector<double>*> series_;  // by joint; null: no command (passive)
  std::vector<std::vector<double>> altered_;        // storage of series that are not the drive's
  std::vector<double> delay_;                       // s
};

}  // namespace sanso::diagnose
