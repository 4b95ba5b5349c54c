// Hold, loss and scatter change the series once, at construction; without a seed, loss is its
// expected value and nothing scatters.
#include "tools/diagnose/sim/command_path.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace sanso::diagnose {
namespace {

/// Commands that arrive a little early or late, by what they are in the mean between two rows.
void scatter(const std::vector<double>& command, const std::vector<double>& t, double most,
             std::mt19937_64& random, std::vector<double>& out) {
  std::uniform_real_distribution<> late(-most, most);
  for (std::size_t k = 1; k < out.size(); ++k) {
    const double share = late(random) / (t[k] - t[k - 1]), change = command[k] - command[k - 1];
    if (!std::isfinite(change)) continue;
    if (share > 0.0)
      out[k] -= std::min(share, 1.0) * change;
    else
      out[k - 1] -= std::max(share, -1.0) * change;
  }
}

std::vector<double> altered(const std::vector<double>& command, const std::vector<double>& t,
                            const JointParams& joint, std::mt19937_64* random) {
  std::vector<double> out = command;
  for (std::size_t k = 1; k < out.size(); ++k) {
    if (joint.hold_cycles > 1 && k % static_cast<std::size_t>(joint.hold_cycles) != 0)
      out[k] = out[k - 1];
    if (joint.loss > 0.0 && std::isfinite(out[k]) && std::isfinite(out[k - 1])) {
      if (random == nullptr) {
        out[k] = (1.0 - joint.loss) * out[k] + joint.loss * out[k - 1];  // E[held value]
      } else if (std::uniform_real_distribution<>()(*random) < joint.loss) {
        out[k] = out[k - 1];
      }
    }
  }
  if (joint.command_scatter > 0.0 && random != nullptr)
    scatter(std::vector<double>(out), t, joint.command_scatter, *random, out);
  return out;
}

}  // namespace

CommandPath::CommandPath(const SimParams& params, const Drive& drive, std::uint64_t random_seed)
    : t_(drive.t), altered_(drive.joints.size()) {
  std::mt19937_64 random(random_seed);
  for (std::size_t j = 0; j < drive.joints.size(); ++j) {
    const JointParams& joint = params.joints[j];
    const std::vector<double>* series =
        drive.joints[j].command.empty() ? nullptr : &drive.joints[j].command;
    if (series != nullptr &&
        (joint.hold_cycles > 1 || joint.loss > 0.0 || joint.command_scatter > 0.0)) {
      altered_[j] = altered(*series, drive.t, joint, random_seed == 0 ? nullptr : &random);
      series = &altered_[j];
    }
    series_.push_back(series);
    delay_.push_back(joint.nominal.command_delay_s + joint.command_delay);
  }
}

CommandPath::Command CommandPath::over(std::size_t j, double from, double until,
                                       std::size_t& cursor) const {
  if (series_[j] == nullptr) return {0.0, 0.0, true};
  const std::vector<double>& u = *series_[j];
  from -= delay_[j];
  until -= delay_[j];
  const double middle = 0.5 * (from + until);
  std::size_t& k = cursor;
  if (k == kUnset) {
    const auto after = std::upper_bound(t_.begin(), t_.end(), from);
    k = after == t_.begin() ? 0 : static_cast<std::size_t>(after - t_.begin()) - 1;
  }
  while (k + 1 < t_.size() && t_[k + 1] <= from) ++k;
  // held from sample to sample: integrate piecewise over [from, until]; usually it is one piece
  std::size_t at_middle = k;
  double value = u[k];
  if (k + 1 < t_.size() && t_[k + 1] < until) {
    double begin = from, sum = 0.0, covered = 0.0;
    for (std::size_t i = k; begin < until; ++i) {
      const double end = i + 1 < t_.size() ? std::min(until, t_[i + 1]) : until;
      if (std::isfinite(u[i])) {
        sum += u[i] * (end - begin);
        covered += end - begin;
      }
      if (begin <= middle) at_middle = i;
      begin = end;
    }
    if (covered > 0.0) value = sum / covered;
  }
  const bool off = !std::isfinite(u[at_middle]);
  double rate = 0.0;
  if (at_middle > 0 && !off && std::isfinite(u[at_middle - 1])) {
    rate = (u[at_middle] - u[at_middle - 1]) / (t_[at_middle] - t_[at_middle - 1]);
  }
  return {value, rate, off};
}

}  // namespace sanso::diagnose
