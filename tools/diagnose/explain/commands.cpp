// Rows, changes and sorted lists of commands.
#include "tools/diagnose/explain/commands.h"

#include <algorithm>
#include <utility>

namespace sanso::diagnose {

Commands::Commands(std::shared_ptr<const Comparison> comparison, const SimParams& params)
    : comparison_(std::move(comparison)) {
  for (const JointParams& p : params.joints) {
    delay_.push_back(p.nominal.command_delay_s + p.command_delay + p.nominal.sensor_delay_s +
                     p.sensor_delay);
  }
}

const std::vector<double>& Commands::of(std::size_t source, std::size_t joint) const {
  return comparison_->sources[source].drive.joints[joint].command;
}

std::size_t Commands::first_row(const Shot& shot, std::size_t joint) const {
  const std::vector<double>& t = comparison_->sources[shot.source].drive.t;
  const double early = delay_[joint];
  std::size_t row = shot.window.first;
  while (row > 1 && t[row] > t[shot.window.first] - early) --row;
  return std::max<std::size_t>(row, 1);
}

bool Commands::changes(std::size_t source, std::size_t joint, std::size_t row) const {
  const std::vector<double>& u = of(source, joint);
  return row < u.size() && std::isfinite(u[row]) && std::isfinite(u[row - 1]) &&
         u[row] != u[row - 1];
}

double Commands::missed(std::size_t source, std::size_t joint, std::size_t row,
                        std::size_t run) const {
  const std::vector<double>& u = of(source, joint);
  double sum = 0.0;
  for (std::size_t k = row; k < std::min(u.size(), row + run) && std::isfinite(u[k]); ++k)
    sum += u[k] - u[row - 1];
  return sum;
}

double Commands::count(const std::vector<std::size_t>& joints) const {
  double sum = 0.0;
  for (const std::size_t joint : joints) {
    for (const Shot& shot : comparison_->shots) {
      for (std::size_t row = first_row(shot, joint); row < shot.window.last; ++row)
        sum += changes(shot.source, joint, row) ? 1.0 : 0.0;
    }
  }
  return sum;
}

void put(std::vector<LostCommand>& lost, const Shot& shot, std::size_t joint,
         const Change& change) {
  for (std::size_t k = 0; k < change.run; ++k) {
    const LostCommand one{shot.source, joint, change.row + k};
    const auto at = std::lower_bound(lost.begin(), lost.end(), one);
    const bool there = at != lost.end() && !(one < *at);
    if (there && change.run == 1) lost.erase(at);
    if (!there) lost.insert(at, one);
  }
}

std::vector<LostCommand> between(const std::vector<LostCommand>& lost, std::size_t source,
                                 std::size_t joint, std::size_t from, std::size_t until) {
  const auto first = std::lower_bound(lost.begin(), lost.end(), LostCommand{source, joint, from});
  return {first, std::lower_bound(first, lost.end(), LostCommand{source, joint, until})};
}

bool holds(const std::vector<LostCommand>& lost, const LostCommand& command) {
  return std::binary_search(lost.begin(), lost.end(), command);
}

}  // namespace sanso::diagnose
