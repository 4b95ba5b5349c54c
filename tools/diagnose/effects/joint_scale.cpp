// The scale of a joint from its motor, its limits, or the peaks of commands and speeds in the
// recordings, glitches left out.
#include "tools/diagnose/effects/joint_scale.h"

#include <algorithm>
#include <cmath>

#include "shared/math/order_statistics.h"
#include "tools/diagnose/sim/tree_dynamics.h"

namespace sanso::diagnose {
namespace {

/// Largest magnitude but for the top permille (glitches).
double robust_peak(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return 0.0;
  for (double& v : values) v = std::abs(v);
  return math::quantile_below(std::span(values), 0.999);
}

struct Seen {
  double command = 0.0, speed = 0.0, range = 0.0;
};
Seen seen_in(std::span<const Drive> drives, std::size_t j) {
  Seen seen;
  for (const Drive& drive : drives) {
    const JointData& data = drive.joints[j];
    seen.command = std::max(seen.command, robust_peak(data.command));
    std::vector<double> speeds;
    double low = INFINITY, high = -INFINITY;
    for (std::size_t k = 0, step = std::max<std::size_t>(1, drive.rows() / 2000);
         k + step < drive.rows(); k += step) {
      const double dt = drive.t[k + step] - drive.t[k];
      speeds.push_back((data.q[k + step] - data.q[k]) / std::max(dt, 0.02));  // slower than noise
    }
    for (double q : data.q) {
      if (std::isfinite(q)) low = std::min(low, q), high = std::max(high, q);
    }
    seen.speed = std::max(seen.speed, robust_peak(speeds));
    if (high > low) seen.range = std::max(seen.range, high - low);
  }
  return seen;
}

/// Distance from the joint to the middle of the link, m: by its centre of mass, by its radius of
/// gyration about the joint, and by the next joint. Of a uniform rod all three say half its length;
/// a counterweight hides it from the first, a short link of unknown inertia from the others.
double half_reach(const RobotTree& tree, std::size_t j) {
  const auto square = [](const Vec3& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; };
  const BodyInertia& body = tree.joints[j].body;
  double reach = std::sqrt(square(body.com));
  if (body.mass > 0.0) {
    const double trace = body.about_com[0] + body.about_com[4] + body.about_com[8];
    const double gyration = std::sqrt(0.5 * trace / body.mass + square(body.com));
    reach = std::max(reach, std::sqrt(0.75) * gyration);
  }
  for (const TreeJoint& next : tree.joints) {
    if (next.parent == static_cast<int>(j))
      reach = std::max(reach, 0.5 * std::sqrt(square(next.p_parent_joint)));
  }
  return reach;
}

double stall_torque(const JointSettings& s) { return s.torque_constant * s.voltage / s.resistance; }

}  // namespace

std::vector<JointScale> joint_scales(const SimParams& params, std::span<const Drive> drives,
                                     const LibrarySettings& library) {
  TreeDynamics tree(params.tree, params.gravity);
  JointVector zero{}, gravity{};
  JointMatrix M{};
  tree.set_positions(zero.data());
  tree.mass_matrix(M);
  JointVector peak_gravity{};
  for (double turn : {0.0, 0.8, 1.6, -0.8}) {  // a few postures: what gravity can ask of the joint
    JointVector q;
    q.fill(turn);
    tree.set_positions(q.data());
    tree.bias(zero.data(), gravity);
    for (std::size_t j = 0; j < params.joints.size(); ++j)
      peak_gravity[j] = std::max(peak_gravity[j], std::abs(gravity[j]));
  }
  std::vector<JointScale> scales;
  for (std::size_t j = 0; j < params.joints.size(); ++j) {
    const JointSettings& s = params.joints[j].nominal;
    const TreeJoint& joint = params.tree.joints[j];
    const Seen seen = seen_in(drives, j);
    const double inertia = M[j * kMaxJoints + j] + s.armature;
    const double limit = s.torque_limit > 0.0 ? s.torque_limit : kNone;
    double torque = 0.0, speed = 2.0 * seen.speed;
    if (s.actuator == Actuator::dc_servo) {
      torque = std::min(stall_torque(s), limit);
      if (s.back_emf > 0.0) speed = s.voltage / s.back_emf;
    } else if (s.actuator == Actuator::torque && seen.command > 0.0) {
      torque = std::min(library.reserve * seen.command, limit);
    } else if (s.actuator == Actuator::position_pd && limit < kNone) {
      torque = limit;
    } else {
      // to speed within 0.1 s
      torque = library.reserve * std::max(peak_gravity[j], inertia * seen.speed / 0.1);
    }
    JointScale scale;
    scale.torque = std::max(torque, 1e-6) / library.torque;
    scale.speed = std::max(speed, 1e-3) / library.speed;
    // a strong drive has a heavy rotor, however light the link it turns
    scale.inertia = std::max(inertia / library.inertia, scale.torque);
    // a revolute joint's range is about 2 rad
    if (joint.prismatic) scale.angle = std::max(seen.range, 1e-3) / 2.0;
    if (s.actuator == Actuator::dc_servo)
      scale.current = s.voltage / s.resistance / library.current;
    const Vec3& c = joint.body.com;
    const double arm = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    scale.length = std::max(arm, 0.01) / library.length;
    scale.reach = std::max(half_reach(params.tree, j), 0.01) / library.length;
    scales.push_back(scale);
  }
  return scales;
}

std::string why_untestable(const Effect& effect, const SimParams& params,
                           std::span<const Drive> drives, int where) {
  if (effect.needs & kGround) return "the base is fixed: nothing touches the ground";
  if (effect.needs & kImu) return "the base is fixed: its IMU sees no motion";
  if ((effect.needs & kTwoJoints) && params.size() < 2) return "one joint only";
  const auto any = [&](auto&& test) {
    for (std::size_t j = 0; j < params.size(); ++j) {
      if ((where < 0 || where == static_cast<int>(j)) && test(j)) return true;
    }
    return false;
  };
  const auto actuator = [&](std::size_t j) { return params.joints[j].nominal.actuator; };
  const auto recorded = [&](auto member, std::size_t j) {
    return std::any_of(drives.begin(), drives.end(),
                       [&](const Drive& d) { return !(d.joints[j].*member).empty(); });
  };
  if ((effect.needs & kMotorModel) &&
      !any([&](std::size_t j) { return actuator(j) == Actuator::dc_servo; })) {
    return "needs a motor model (actuator dc_servo)";
  }
  if ((effect.needs & kPositionLoop) && !any([&](std::size_t j) {
        return actuator(j) == Actuator::dc_servo || actuator(j) == Actuator::position_pd;
      })) {
    return "the actuator has no position loop";
  }
  if ((effect.needs & kCommand) &&
      !any([&](std::size_t j) { return actuator(j) != Actuator::passive; })) {
    return "the joint has no actuator";
  }
  if ((effect.needs & kTorqueLimit) && !any([&](std::size_t j) {
        return actuator(j) == Actuator::dc_servo ||
               (actuator(j) != Actuator::passive && params.joints[j].nominal.torque_limit > 0.0);
      })) {
    return "the model states no torque_limit";
  }
  if ((effect.needs & kVelocity) &&
      !any([&](std::size_t j) { return recorded(&JointData::dq, j); }))
    return "no dq: column";
  if ((effect.needs & kTemperature) && !any([&](std::size_t j) {
        return recorded(&JointData::temp, j) || actuator(j) == Actuator::dc_servo;
      })) {
    return "no temp: column and no motor model to estimate heating";
  }
  return {};
}

}  // namespace sanso::diagnose
