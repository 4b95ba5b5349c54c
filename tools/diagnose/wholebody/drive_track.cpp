// Joints and turning are smoothed, row by row; what the accelerometer feels is moved to the base's
// origin. Goals are not smoothed: they are held for a row and jump.
#include "tools/diagnose/wholebody/drive_track.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tools/diagnose/compare/measured_motion.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/stats/smoother.h"

namespace sanso::diagnose {
namespace {

using Vector = Eigen::VectorXd;

/// Rate of x from the row before to each row; 0 at the first.
std::vector<double> differences(const std::vector<double>& t, const std::vector<double>& x) {
  std::vector<double> out(x.size(), 0.0);
  for (std::size_t k = 1; k < x.size(); ++k) out[k] = (x[k] - x[k - 1]) / (t[k] - t[k - 1]);
  return out;
}

/// error = before - q,  `before` the goal that acts and q as recorded; the q that is kept is less
/// the encoder's zero.
JointTrack track_of_joint(const Asking& asking, const WholeRecording& r, Eigen::Index j) {
  JointTrack out;
  const Vector row = r.q.row(j);
  out.q.assign(row.data(), row.data() + row.size());
  const SmoothedState s = smooth_position(r.t, out.q, position_noise(out.q), asking.smoother);
  out.dq = s.dq, out.ddq = s.ddq;
  // a current is read at an instant, at which the goal of the row before acts; what moves feels
  // either half of both rows
  std::vector<double> before(r.rows());
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const auto now = static_cast<Eigen::Index>(k),
               last = static_cast<Eigen::Index>(k > 0 ? k - 1 : 0);
    before[k] = r.current ? r.u(j, last) : 0.5 * (r.u(j, last) + r.u(j, now));
  }
  out.command_rate = differences(r.t, before);
  const auto joint = static_cast<std::size_t>(j);
  const double zero = joint < asking.known.zero.size() ? asking.known.zero[joint] : 0.0;
  for (std::size_t k = 0; k < r.rows(); ++k) {
    out.error.push_back(before[k] - out.q[k]), out.q[k] -= zero;
    if (r.current) out.current.push_back(r.i(j, static_cast<Eigen::Index>(k)));
  }
  return out;
}

/// Sum of fz over force_scale, N. NaN where a foot comes down or off (its force jumps by a share of
/// the weight in a row): a sensor that is read a hundred times a second says nothing of an impact.
double weight_at(const Asking& asking, const WholeRecording& r, std::size_t k) {
  const double jump =
      asking.stance.jump * asking.body.mass() * eigen(asking.body.model.gravity).norm();
  double sum = 0.0;
  for (const FootForce& foot : r.feet) {
    sum += foot.fz[k];
    if (k > 0 && !(std::abs(foot.fz[k] - foot.fz[k - 1]) < jump))
      return std::numeric_limits<double>::quiet_NaN();
  }
  return sum / asking.known.force_scale;
}

}  // namespace

Track track_of(const Asking& asking, const WholeRecording& r) {
  Track out;
  const auto joints = static_cast<std::size_t>(r.q.rows());
  out.joints.resize(joints);
  std::array<SmoothedState, 3> turning;
  parallel_for(joints + 3, [&](std::size_t i) {
    if (i < joints) {
      out.joints[i] = track_of_joint(asking, r, static_cast<Eigen::Index>(i));
      return;
    }
    std::vector<double> w;
    for (const V3& x : r.w) w.push_back(x[static_cast<Eigen::Index>(i - joints)]);
    turning[i - joints] = smooth_position(r.t, w, position_noise(w), asking.smoother);
  });
  const ImuPlace& imu = asking.body.imu;
  const M3 R = eigen(imu.R_joint_imu);
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const V3 w(turning[0].q[k], turning[1].q[k], turning[2].q[k]);
    const V3 dw(turning[0].dq[k], turning[1].dq[k], turning[2].dq[k]);
    const V3 at = eigen(imu.p_joint_imu);
    out.w.push_back(w), out.dw.push_back(dw);
    // a rigid body:  acc = R imu_turn (imu_acc - acc_bias) - dw x at - w x (w x at)
    out.acc.push_back(R * asking.known.imu_turn * (r.imu_acc[k] - asking.known.acc_bias) -
                      dw.cross(at) - w.cross(w.cross(at)));
    if (r.attitude) out.up.push_back(r.R[k].transpose() * V3::UnitZ());
    if (!r.feet.empty()) out.weight.push_back(weight_at(asking, r, k));
  }
  out.feet = r.feet;
  return out;
}

namespace {

/// Joints of feet whose force is never more than what a sensor reads in the air.
std::vector<int> feet_in_air(const Asking& asking, const Track& track, std::size_t a,
                             std::size_t b) {
  const double least =
      asking.stance.carries * asking.body.mass() * eigen(asking.body.model.gravity).norm();
  std::vector<int> out;
  for (const FootForce& foot : track.feet) {
    bool carries = false;
    for (std::size_t k = a; k < b; ++k) carries = carries || !(std::abs(foot.fz[k]) < least);
    if (!carries) out.push_back(foot.joint);
  }
  return out;
}

}  // namespace

WindowMeans window_of(const Asking& asking, const Track& track, std::size_t a, std::size_t b) {
  // slower, a joint's direction is a part of one
  const double creeping = asking.stance.creeping;
  const auto n = static_cast<Eigen::Index>(track.joints.size());
  WindowMeans out;
  for (Vector* v : {&out.motion.q, &out.motion.dq, &out.motion.ddq, &out.sign, &out.error,
                    &out.command_rate, &out.current})
    *v = Vector::Zero(n);
  out.in_air = feet_in_air(asking, track, a, b);
  // means over [a, b) of every track;  sign = mean of dq / creeping within [-1, 1]
  const double share = 1.0 / static_cast<double>(b - a);
  for (std::size_t k = a; k < b; ++k) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const JointTrack& t = track.joints[static_cast<std::size_t>(j)];
      out.motion.q[j] += share * t.q[k], out.motion.dq[j] += share * t.dq[k];
      out.motion.ddq[j] += share * t.ddq[k];
      out.sign[j] += share * std::clamp(t.dq[k] / creeping, -1.0, 1.0);
      out.error[j] += share * t.error[k], out.command_rate[j] += share * t.command_rate[k];
      if (!t.current.empty()) out.current[j] += share * t.current[k];
    }
    out.motion.acc += share * track.acc[k], out.motion.w += share * track.w[k];
    out.motion.dw += share * track.dw[k];
    if (!track.up.empty()) out.up += share * track.up[k];
    if (!track.weight.empty()) out.weight += share * track.weight[k];
  }
  return out;
}

}  // namespace sanso::diagnose
