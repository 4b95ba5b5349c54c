// The smoothed motion of a recording, from which every simulation starts.
#include "tools/diagnose/compare/measured_motion.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/smoother.h"

namespace sanso::diagnose {

double position_noise(const std::vector<double>& q) {
  std::vector<double> second, steps;
  for (std::size_t k = 1; k + 1 < q.size(); ++k) {
    second.push_back((q[k + 1] - 2 * q[k] + q[k - 1]) / std::sqrt(6.0));
    if (const double step = std::abs(q[k] - q[k - 1]); step > 1e-9) steps.push_back(step);
  }
  const double range = quantile(q, 1.0) - quantile(q, 0.0);
  // the encoder's, when it is coarser than the noise
  const double smallest_step = steps.empty() ? 0.0 : quantile(steps, 0.01);
  return std::max({robust_sigma(second), smallest_step / std::sqrt(12.0), 1e-6 * range, 1e-9});
}

MeasuredMotion measured_motion(const Drive& drive, const Settings& settings) {
  MeasuredMotion motion;
  for (const JointData& joint : drive.joints) {
    const std::vector<double> q = gate::without_glitches(joint.q, nullptr, settings.gate);
    SmoothedState state = smooth_position(drive.t, q, position_noise(q), settings.smoother,
                                          settings.data.likelihood_rows);
    motion.q.push_back(std::move(state.q));
    motion.dq.push_back(std::move(state.dq));
  }
  return motion;
}

std::vector<Window> tiled_windows(const Drive& drive, const MeasuredMotion& motion,
                                  double seconds) {
  std::vector<Window> windows;
  const std::vector<double>& t = drive.t;
  for (std::size_t first = 0; first + 1 < t.size();) {
    std::size_t last = first;
    while (last + 1 < t.size() && t[last + 1] - t[first] <= seconds + 1e-9) ++last;
    if (last == first) ++last;  // a gap longer than the window
    if (!windows.empty() && t[last] - t[first] < 0.5 * seconds) break;
    Window window{first, last, {}, {}};
    for (std::size_t j = 0; j < motion.q.size(); ++j) {
      window.q.push_back(motion.q[j][first]);
      window.dq.push_back(motion.dq[j][first]);
    }
    windows.push_back(std::move(window));
    first = last;
  }
  return windows;
}

}  // namespace sanso::diagnose
