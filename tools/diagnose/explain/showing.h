// Which losses of commands would show. A share of lost commands is counted where a loss could not
// have been missed, and chance is told by where none is found.
#pragma once

#include <map>
#include <tuple>
#include <vector>

#include "tools/diagnose/explain/hunt.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {

/// A run of losses: rows [first, first + length) of one joint's commands.
struct Run {
  LostCommand first;
  std::size_t length = 1;
};

/// Commands, and those of them that were lost.
struct Counted {
  int commands = 0, lost = 0;
  /// Of the share lost, 95 %, when as many as `together` events are one.
  Interval interval(double together) const;
};

class Showing {
 public:
  /// Of what `hunt` takes to be lost; simulates every command of these joints once.
  Showing(const Hunt& hunt, std::vector<std::size_t> joints);

  struct Split {
    Counted visible, hidden;
  };
  /// Commands and those lost, by whether a run of typical length that begins there would show.
  Split count() const;
  /// Losses come in runs: how many count as one independent event (mean square of the runs' lengths
  /// over their mean).
  double run_effect() const;
  /// Share of the losses found that are in runs that would show.
  double share_seen() const;
  /// Probability that chance spreads the shots with losses over the recordings as unevenly as they
  /// are, by how many commands of each would show: of the recording with more than its share, times
  /// the recordings. A burst that was found in pieces is one shot all the same.
  double chance_of_spread() const;

 private:
  bool shows(const Run& run, double times) const;
  bool typically(const LostCommand& at) const;
  template <class F>
  void each_command(const Shot& shot, const F& f) const;

  const Hunt& hunt_;
  std::vector<std::size_t> joints_;
  std::vector<Run> runs_;
  std::size_t typical_ = 1;  // length of a run: half are no longer
  // energy that a command's loss changes by the square of what the servo misses [1 / rad^2]: where
  // a drive has nothing left to give a loss changes nothing, whatever the jump
  std::map<std::tuple<std::size_t, std::size_t, std::size_t>, double> response_;
};

}  // namespace sanso::diagnose
