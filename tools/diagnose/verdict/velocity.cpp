// Readings of the velocity channel less the smoothed motion e(v), less offset and gain error:
//
//   gain = cov(v, e) / var(v), clamped to what a sensor may have;   missing = e - mean - gain v
#include "tools/diagnose/verdict/velocity.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

double noise_of(const std::vector<NoiseLevel>& noise, const std::string& channel) {
  const auto at = std::find_if(noise.begin(), noise.end(),
                               [&](const NoiseLevel& n) { return n.channel == channel; });
  return at == noise.end() ? 0.0 : at->sigma;
}

/// Rows `first`, `first + stride`, ... of one recording's joint. The acceleration is the smoothed
/// velocity's central difference.
void add_samples(const Source& source, std::size_t source_index, std::size_t joint, double noise,
                 std::size_t stride, std::vector<TorqueSample>& out) {
  const std::vector<double>& t = source.drive.t;
  const std::vector<double>& reading = source.drive.joints[joint].dq;
  const std::vector<double>& dq = source.motion.dq[joint];
  for (std::size_t k = 1; k + 1 < std::min(reading.size(), t.size()); k += stride) {
    if (!std::isfinite(reading[k])) continue;
    TorqueSample s;
    s.source = source_index;
    s.joint = joint;
    s.row = k;
    s.t = t[k];
    s.q = source.motion.q[joint][k];
    s.dq = dq[k];
    s.ddq = (dq[k + 1] - dq[k - 1]) / std::max(t[k + 1] - t[k - 1], 1e-9);
    s.missing = reading[k] - dq[k];
    s.sigma = std::hypot(noise, source.dq_sigma[joint][k]);
    out.push_back(s);
  }
}

/// Takes a sensor's offset and gain error out of one joint's samples, the gain error no further
/// than `reach`.
void take_out_calibration(std::vector<TorqueSample>::iterator from,
                          std::vector<TorqueSample>::iterator until, double reach) {
  const double n = static_cast<double>(until - from);
  if (n < 3.0) return;
  double v = 0.0, e = 0.0, vv = 0.0, ve = 0.0;
  for (auto s = from; s != until; ++s) v += s->dq / n, e += s->missing / n;
  for (auto s = from; s != until; ++s)
    vv += (s->dq - v) * (s->dq - v), ve += (s->dq - v) * (s->missing - e);
  const double gain = vv > 0.0 ? std::clamp(ve / vv, -reach, reach) : 0.0;
  for (auto s = from; s != until; ++s) s->missing -= e + gain * (s->dq - v);
}

}  // namespace

std::vector<TorqueSample> velocity_errors(const std::vector<Source>& sources,
                                          const std::vector<NoiseLevel>& noise,
                                          const Settings& settings) {
  std::vector<TorqueSample> out;
  const std::vector<TreeJoint>& joints = sources.front().nominal.tree.joints;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    std::size_t rows = 0;
    for (const Source& s : sources) rows += s.motion.q[j].empty() ? 0 : s.drive.joints[j].dq.size();
    const std::size_t stride =
        std::max<std::size_t>(1, rows / static_cast<std::size_t>(settings.data.velocity_samples));
    const auto from = static_cast<std::ptrdiff_t>(out.size());
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (sources[i].drive.joints[j].q.empty()) continue;  // nothing to compare with
      add_samples(sources[i], i, j, noise_of(noise, "dq:" + joints[j].name), stride, out);
    }
    take_out_calibration(out.begin() + from, out.end(), settings.data.secondary_floor);
  }
  return out;
}

}  // namespace sanso::diagnose
