// What the servos were told, and which of it is taken for lost.
#pragma once

#include <cmath>
#include <vector>

#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose {

/// Commands of a problem's recordings, as a model with `params` receives them.
class Commands {
 public:
  Commands(const Problem& problem, const SimParams& params);

  /// Command by row [rad]; NaN: none.
  const std::vector<double>& of(int source, int joint) const;
  /// First row whose command acts in a shot: those still under way at its start count.
  std::size_t first_row(const Shot& shot, int joint) const;
  /// What the servo does not notice when it is lost is no event.
  bool changes(int source, int joint, std::size_t row) const;
  /// Size of a change, rad.
  double jump(int source, int joint, std::size_t row) const;
  /// Commands at these joints whose loss would be noticed, in all shots together.
  double count(const std::vector<int>& joints) const;

 private:
  const Problem& problem_;
  std::vector<double> delay_;  // by joint, s: from command to reading
};

/// A change of what one shot is taken to have lost.
struct Change {
  // run 1: the row is lost, or no longer; longer: all of these are lost
  std::size_t row = 0, run = 0;
  double gain = -INFINITY;  // energy that it takes from the shot, less the price
  double energy = 0.0;      // the same without the price
  double made = 0.0;        // energy of the change it makes
};

/// Puts a change of one shot into sorted losses.
void put(std::vector<LostCommand>& lost, const Shot& shot, int joint, const Change& change);

/// Of sorted losses those of one joint, in the rows [from, until) of a recording.
std::vector<LostCommand> between(const std::vector<LostCommand>& lost, int source, int joint,
                                 std::size_t from, std::size_t until);

bool holds(const std::vector<LostCommand>& lost, const LostCommand& command);

}  // namespace sanso::diagnose
