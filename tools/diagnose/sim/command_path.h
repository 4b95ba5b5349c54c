// Clock and command path: what the servo of a joint is asked for between two instants, after delay,
// hold and loss.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/diagnose/sim/drive.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

class CommandPath {
 public:
  /// random_seed 0: a lost command is replaced by its expectation; otherwise losses are drawn.
  CommandPath(const SimParams& params, const Drive& drive, std::uint64_t random_seed);

  struct Command {
    double value;  // mean over the interval; meaningless when off
    double rate;   // per second, of the sample interval
    bool off;      // empty cell: the actuator is switched off
  };
  /// The command of joint j that acts during [from, until]. Calls for one joint go forward in time
  /// between rewinds.
  Command over(int j, double from, double until);
  void rewind() { cursor_.assign(cursor_.size(), kUnset); }

 private:
  static constexpr std::size_t kUnset = static_cast<std::size_t>(-1);
  const std::vector<double>& t_;
  std::vector<const std::vector<double>*> series_;  // by joint; null: no command (passive)
  std::vector<std::vector<double>> altered_;        // storage of series that hold or loss changes
  std::vector<double> delay_;                       // s
  std::vector<std::size_t> cursor_;
};

}  // namespace sanso::diagnose
