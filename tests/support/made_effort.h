// Rows of a regression made by hand: a motion known exactly, the effort that a model needs for it,
// and what a test adds to it. No smoother stands between the truth and what is fitted.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "tests/support/small_world.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/torque/effort_rows.h"

namespace sanso::diagnose::test {

/// Three sines of unrelated speeds at every joint, with their exact derivatives.
inline MotionSample made_motion(int joints, double t) {
  MotionSample m;
  for (int j = 0; j < joints; ++j) {
    const auto i = static_cast<std::size_t>(j);
    for (int k = 0; k < 3; ++k) {
      const double w = 0.9 + 0.7 * j + (1.9 + 0.3 * j) * k, size = 0.9 / (1.0 + k);
      m.q[i] += size * std::sin(w * t + j + k);
      m.dq[i] += size * w * std::cos(w * t + j + k);
      m.ddq[i] -= size * w * w * std::sin(w * t + j + k);
    }
  }
  return m;
}

/// What is in the effort of a joint beside what the model needs.
using Missing = std::function<double(int joint, const MotionSample&, const NeededEffort&)>;

/// One row for every joint and instant, recorded as tau:, with normal noise.
inline EffortRows made_effort(const ModelFolder& model, double noise, const Missing& missing,
                              std::uint64_t seed = 1) {
  EffortRows out;
  EffortRecording r;
  r.file = "made.csv";
  r.nominal = params_with_effects(model);
  const std::size_t joints = model.tree.size();
  r.effort.resize(joints);
  r.moves.resize(joints);
  for (const TreeJoint& joint : model.tree.joints)
    r.channels.push_back({"tau:" + joint.name, joint.prismatic ? "N" : "N m", true, false, {}});
  InverseEffort inverse(r.nominal);
  Random random(seed);
  constexpr std::size_t kInstants = 600, kBlock = 30;
  for (std::size_t k = 0; k < kInstants; ++k) {
    r.t.push_back(0.05 * static_cast<double>(k));
    r.motion.push_back(made_motion(static_cast<int>(joints), r.t.back()));
    r.nominal_needs.push_back(inverse.at(r.motion.back()));
    for (std::size_t j = 0; j < joints; ++j) {
      const NeededEffort& need = r.nominal_needs.back()[j];
      EffortRow row{0, j, k, k + 1, k / kBlock, 0.0, need.total()};
      row.effort = need.total() + missing(static_cast<int>(j), r.motion.back(), need) +
                   noise * random.normal();
      r.effort[j].push_back(row.effort);
      r.moves[j].push_back(1);
      out.rows.push_back(row);
    }
  }
  out.blocks = kInstants / kBlock;
  out.recording_of_block.assign(out.blocks, 0);
  out.recordings.push_back(std::move(r));
  return out;
}

}  // namespace sanso::diagnose::test
