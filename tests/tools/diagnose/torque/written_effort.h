// Rows of the torque side whose truth is written by hand: a motion by formula, and an effort that
// is the nominal one, what is missing, and white noise from a seed.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/small_world.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/torque/effort_rows.h"

namespace sanso::diagnose::test {

inline constexpr double kStep = 0.01, kBlock = 0.25, kNoise = 0.02;  // s, s, N m

using Angle = std::function<double(int joint, double t)>;
/// What a joint's effort holds beyond the nominal model, N m. `part`: 0 at the begin, 1 at the end.
using Missing = std::function<double(const MotionSample&, int joint, double part)>;

inline double sines(int j, double t) {
  return 0.9 * std::sin((2.1 + 1.3 * j) * t) + 0.5 * std::sin((5.3 + 0.9 * j) * t + j);
}
inline double sign(double x) { return x > 0.0 ? 1.0 : -1.0; }

/// One recording: every derivative by differences of the formula.
inline EffortRecording recorded(const ModelFolder& model, const std::string& file, double seconds,
                                const Angle& angle) {
  EffortRecording out;
  out.file = file;
  out.nominal = params_with_effects(model);
  out.channels = std::vector<EffortChannel>(out.nominal.joints.size());
  for (std::size_t j = 0; j < out.channels.size(); ++j)
    out.channels[j] = {"tau:" + out.nominal.tree.joints[j].name, "N m", true, false, {}};
  InverseEffort inverse(out.nominal);
  for (double t = 0.0; t < seconds; t += kStep) {
    MotionSample m;
    for (int j = 0; j < static_cast<int>(out.channels.size()); ++j) {
      const double h = 1e-4, before = angle(j, t - h), now = angle(j, t), after = angle(j, t + h);
      const auto i = static_cast<std::size_t>(j);
      m.q[i] = now, m.dq[i] = (after - before) / (2 * h);
      m.ddq[i] = (after - 2 * now + before) / (h * h);
    }
    out.t.push_back(t), out.motion.push_back(m), out.nominal_needs.push_back(inverse.at(m));
  }
  return out;
}

/// Rows of one instant each, with the truth and its noise in their efforts.
inline EffortRows rows_of(std::vector<EffortRecording> recordings, const Missing& missing,
                          double noise = kNoise, std::uint64_t seed = 1) {
  EffortRows out;
  Random random(seed);
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const EffortRecording& from = recordings[r];
    const std::size_t first = out.blocks;
    for (std::size_t k = 0; k < from.t.size(); ++k) {
      const std::size_t block = first + static_cast<std::size_t>(from.t[k] / kBlock);
      while (out.blocks <= block) ++out.blocks, out.recording_of_block.push_back(r);
      for (std::size_t j = 0; j < from.channels.size(); ++j) {
        EffortRow row{r, j, k, k + 1, block};
        row.nominal = from.nominal_needs[k][j].total();
        row.effort = row.nominal + noise * random.normal() +
                     missing(from.motion[k], static_cast<int>(j), from.t[k] / from.t.back());
        out.rows.push_back(row);
      }
    }
  }
  out.recordings = std::move(recordings);
  return out;
}

}  // namespace sanso::diagnose::test
