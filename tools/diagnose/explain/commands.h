// What the servos were told, and which of it is taken for lost.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "tools/diagnose/compare/comparison.h"
#include "tools/diagnose/compare/prediction_error.h"

namespace sanso::diagnose {

/// Commands of what is compared, as a model with `params` receives them.
class Commands {
 public:
  Commands(std::shared_ptr<const Comparison> comparison, const SimParams& params);

  /// Command by row [rad]; NaN: none.
  const std::vector<double>& of(std::size_t source, std::size_t joint) const;
  /// First row whose command acts in a shot: those still under way at its start count.
  std::size_t first_row(const Shot& shot, std::size_t joint) const;
  /// What the servo does not notice when it is lost is no event.
  bool changes(std::size_t source, std::size_t joint, std::size_t row) const;
  /// What a servo misses that holds the command before `row` for `run` rows: sum of the differences
  /// [rad]. Of one row that is how far the command jumps.
  double missed(std::size_t source, std::size_t joint, std::size_t row, std::size_t run) const;
  /// Commands at these joints whose loss would be noticed, in all shots together.
  double count(const std::vector<std::size_t>& joints) const;

 private:
  std::shared_ptr<const Comparison> comparison_;
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
void put(std::vector<LostCommand>& lost, const Shot& shot, std::size_t joint, const Change& change);

/// Of sorted losses those of one joint, in the rows [from, until) of a recording.
std::vector<LostCommand> between(const std::vector<LostCommand>& lost, std::size_t source,
                                 std::size_t joint, std::size_t from, std::size_t until);

/// Whether sorted losses contain this command.
bool holds(const std::vector<LostCommand>& lost, const LostCommand& command);

}  // namespace sanso::diagnose
