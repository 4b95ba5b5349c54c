// Small robots in lively motion, with any effect of the library at every place it can have.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/small_world.h"
#include "tools/diagnose/effects/joint_scale.h"

namespace sanso::diagnose::test {

using Values = std::vector<double>;

/// One second of a small robot in lively motion, motors getting warm, inner states brought along.
struct Trial {
  std::string name;
  ModelFolder model;
  Drive drive;
  MeasuredMotion motion;
  std::vector<Window> windows;
  JointScale scale;  // of the first joint

  explicit Trial(const SmallWorld& world) : name(world.name), model(world.model) {
    const double size = model.tree.joints.front().prismatic ? 0.1 : 0.6;
    drive = make_test_drive(model, 1.0, 0.01, [size](int j, double t) {
      return size * std::sin(7 * t + j) + (t > 0.5 ? 0.3 * size : 0.0);
    });
    const std::size_t joints = drive.joints.size();
    motion.q.resize(joints), motion.dq.resize(joints);
    for (std::size_t j = 0; j < joints; ++j) {
      for (const double t : drive.t) {
        drive.joints[j].temp.push_back(25 + 10 * t);
        motion.q[j].push_back(0.5 * size * std::sin(7 * t));
        motion.dq[j].push_back(3.5 * size * std::cos(7 * t));
      }
      drive.joints[j].q = motion.q[j];
    }
    // starts as measured: what filters remember of the motion and what is seen agree
    for (const std::size_t first : {0u, 40u}) {
      windows.push_back({first, first + 60, {}, {}});
      for (std::size_t j = 0; j < joints; ++j) {
        windows.back().q.push_back(motion.q[j][first]);
        windows.back().dq.push_back(motion.dq[j][first]);
      }
    }
    scale = joint_scales(make_params(model), std::vector{drive}).front();
  }

  std::vector<Prediction> predict(const SimParams& params) const {
    SimOptions options;
    options.motion = &motion;
    return simulate(params, drive, windows, options);
  }
  /// The model with the effect at every place it can have.
  SimParams with(const Effect& effect, const Values& theta) const {
    SimParams params = make_params(model);
    if (effect.scope == Scope::robot) effect.apply(params, -1, theta);
    for (std::size_t j = 0; effect.scope != Scope::robot && j < params.size(); ++j)
      effect.apply(params, static_cast<int>(j), theta);
    return params;
  }
  std::vector<EffectParameter> parameters(const Effect& effect) const {
    std::vector<EffectParameter> out;
    for (const EffectParameter& p : effect.parameters) out.push_back(scaled(p, scale));
    return out;
  }
  Values null(const Effect& effect) const {
    Values theta;
    for (const EffectParameter& p : parameters(effect)) theta.push_back(p.null);
    return theta;
  }
};

inline const std::vector<Trial>& trials() {
  static const std::vector<Trial> all = [] {
    std::vector<Trial> out;
    for (const SmallWorld& world : small_worlds()) out.emplace_back(world);
    return out;
  }();
  return all;
}

inline bool identical(const std::vector<Prediction>& a, const std::vector<Prediction>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Prediction& x, const Prediction& y) {
                      return x.q == y.q && x.dq == y.dq && x.tau == y.tau && x.i == y.i &&
                             x.pwm == y.pwm && x.volt == y.volt;
                    });
}

inline std::vector<std::string> simulated_ids() {
  std::vector<std::string> ids;
  for (const Effect& e : library()) {
    if (e.apply) ids.emplace_back(e.id);
  }
  return ids;
}

}  // namespace sanso::diagnose::test
