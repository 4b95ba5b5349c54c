// The order of preference: what was measured before what was asked for.
#include "tools/diagnose/torque/effort_channels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/diagnose/model_folder/joint_units.h"

namespace sanso::diagnose {
namespace {

using recording::Recording;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<double> values(const Recording& recording, const std::string& column) {
  const auto span = recording.find(column);
  return {span.begin(), span.end()};
}

/// Torque at the shaft of a servo that was given this duty, N m.
std::vector<double> from_duty(const Recording& recording, const JointSettings& s,
                              const std::string& column, const std::vector<double>& dq) {
  std::vector<double> out = values(recording, column);
  const auto volt = recording.find("volt");
  double supply = s.voltage;
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (!volt.empty() && std::isfinite(volt[k])) supply = volt[k];
    out[k] = s.torque_constant * (out[k] * supply - s.back_emf * dq[k]) / s.resistance;
  }
  return out;
}

/// Velocity by central differences: good enough for back-EMF, a small part of a servo's voltage.
std::vector<double> velocity(const Recording& recording, const std::string& joint) {
  std::vector<double> measured = values(recording, "dq:" + joint);
  if (!measured.empty()) return measured;
  const std::vector<double> q = values(recording, "q:" + joint);
  std::vector<double> out(q.size(), kNaN);
  for (std::size_t k = 1; k + 1 < q.size(); ++k)
    out[k] = (q[k + 1] - q[k - 1]) / (recording.t[k + 1] - recording.t[k - 1]);
  return out;
}

EffortChannel take(const Recording& recording, std::string column, std::string unit) {
  EffortChannel out;
  out.effort = values(recording, column);
  out.known = true;
  out.column = std::move(column);
  out.unit = std::move(unit);
  return out;
}

EffortChannel of_servo(const Recording& recording, const JointSettings& s,
                       const std::string& joint) {
  if (recording.has("i:" + joint)) {
    EffortChannel out = take(recording, "i:" + joint, "N m");
    for (double& x : out.effort) x *= s.torque_constant;
    return out;
  }
  EffortChannel out = take(recording, "pwm:" + joint, "N m");
  out.effort = from_duty(recording, s, out.column, velocity(recording, joint));
  return out;
}

/// A column that is never negative though the joint moves both ways: a size, not an effort.
bool has_no_sign(const Recording& recording, const std::string& column, const std::string& joint) {
  const auto x = recording.find(column), q = recording.find("q:" + joint);
  double forth = 0.0, back = 0.0, least = 0.0, last = kNaN;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (std::isfinite(x[k])) least = std::min(least, x[k]);
    if (k >= q.size() || !std::isfinite(q[k])) continue;
    if (std::isfinite(last)) (q[k] > last ? forth : back) += std::abs(q[k] - last);
    last = q[k];
  }
  return least >= 0.0 && forth > 0.25 * back && back > 0.25 * forth;
}

EffortChannel channel_of(const Recording& recording, const TreeJoint& joint,
                         const JointSettings& s) {
  const std::string newton = at_joint("N m", joint.prismatic);
  const std::string& name = joint.name;
  if (recording.has("tau:" + name)) return take(recording, "tau:" + name, newton);
  const bool electrical = recording.has("i:" + name) || recording.has("pwm:" + name);
  if (s.actuator == Actuator::dc_servo && electrical) return of_servo(recording, s, name);
  if (s.actuator == Actuator::torque) {
    for (const char* prefix : {"tau_cmd:", "force_cmd:"}) {
      if (!recording.has(prefix + name)) continue;
      EffortChannel out = take(recording, prefix + name, newton);
      for (double& x : out.effort) x = std::isfinite(x) ? x : 0.0;  // switched off
      return out;
    }
  }
  if (s.actuator == Actuator::passive) {
    EffortChannel out = take(recording, "", newton);
    out.effort.assign(recording.rows(), 0.0);
    return out;
  }
  for (const auto& [prefix, unit] : {std::pair{"i:", "A"}, {"pwm:", "duty"}}) {
    if (!recording.has(prefix + name) || has_no_sign(recording, prefix + name, name)) continue;
    EffortChannel out = take(recording, prefix + name, unit);
    out.gain_unknown = true;
    return out;
  }
  return {};
}

}  // namespace

std::vector<EffortChannel> effort_channels(const Recording& recording, const SimParams& params,
                                           bool free_gain) {
  std::vector<EffortChannel> out;
  for (std::size_t j = 0; j < params.joints.size(); ++j) {
    out.push_back(channel_of(recording, params.tree.joints[j], params.joints[j].nominal));
    if (free_gain && !out.back().column.empty()) out.back().gain_unknown = true;
  }
  return out;
}

}  // namespace sanso::diagnose
