// Joint by joint over windows in the order of its position, between two ends that move along.
#include "tools/diagnose/wholebody/drive_holds.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sanso::diagnose {

std::vector<Eigen::VectorXd> holds_alike(const std::vector<StandingWindow>& windows, double zero) {
  if (windows.empty()) return {};
  const Eigen::Index joints = windows.front().means.motion.q.size();
  std::vector<Eigen::VectorXd> out(windows.size(), Eigen::VectorXd::Ones(joints));
  std::vector<std::size_t> order(windows.size());
  for (Eigen::Index j = 0; j < joints; ++j) {
    const auto q = [&](std::size_t at) { return windows[order[at]].means.motion.q[j]; };
    const auto stands = [&](std::size_t at) {
      return 1.0 - std::abs(windows[order[at]].means.sign[j]);
    };
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return windows[a].means.motion.q[j] < windows[b].means.motion.q[j];
    });
    double standing = 0.0;
    for (std::size_t i = 0, from = 0, to = 0; i < order.size(); ++i) {
      for (; to < order.size() && q(to) <= q(i) + zero; ++to) standing += stands(to);
      for (; q(from) < q(i) - zero; ++from) standing -= stands(from);
      out[order[i]][j] = std::max(1.0, standing);
    }
  }
  return out;
}

}  // namespace sanso::diagnose
