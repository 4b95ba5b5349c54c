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
#include "tools/diagnose/wholebody/lifted_feet.h"

namespace sanso::diagnose {
namespace {

using Vector = Eigen::VectorXd;

/// Rate of x from the row before to each row; 0 at the first.
std::vector<double> differences(const std::vector<double>& t, const std::vector<double>& x) {
  std::vector<double> out(x.size(), 0.0);
  for (std::size_t k = 1; k < x.size(); ++k) out[k] = (x[k] - x[k - 1]) / (t[k] - t[k - 1]);
  return out;
}

/// x as it was `lag` ago; the first value before the recording begins.
std::vector<double> delayed(const std::vector<double>& t, const std::vector<double>& x,
                            double lag) {
  std::vector<double> out(x.size());
  for (std::size_t k = 0, a = 0; k < x.size(); ++k) {
    const double then = t[k] - lag;
    while (a + 1 < k && t[a + 1] <= then) ++a;
    const bool before = k == 0 || then <= t.front();
    const double share = before ? 0.0 : (then - t[a]) / (t[a + 1] - t[a]);
    out[k] = before ? x.front() : x[a] + share * (x[a + 1] - x[a]);
  }
  return out;
}

/// error = before - q,  `before` the goal that acts and q as recorded; the q that is kept is less
/// the encoder's zero.
JointTrack track_of_joint(const Asking& asking, const WholeRecording& r, Eigen::Index j,
                          double lag) {
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
  if (lag > 0.0) before = delayed(r.t, before, lag);
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

Track track_of(const Asking& asking, const WholeRecording& r, const Vector& lags) {
  Track out;
  const auto joints = static_cast<std::size_t>(r.q.rows());
  out.joints.resize(joints);
  std::array<SmoothedState, 3> turning;
  parallel_for(joints + 3, [&](std::size_t i) {
    if (i < joints) {
      const auto j = static_cast<Eigen::Index>(i);
      out.joints[i] = track_of_joint(asking, r, j, lags.size() > 0 ? lags[j] : 0.0);
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
  out.feet = r.feet, out.lifted = lifted_feet(asking, r);
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const bool lost = !out.weight.empty() && !std::isfinite(out.weight[k]);
    const bool stepped = k > 0 && !out.lifted.empty() && out.lifted[k] != out.lifted[k - 1];
    out.impact.push_back(lost || stepped ? 1 : 0);
  }
  return out;
}

namespace {

/// Joints of feet that are in the air in all of these rows.
std::vector<int> lifted_in(const Track& track, std::size_t a, std::size_t b) {
  if (track.lifted.empty()) return {};
  std::vector<int> out = track.lifted[a];
  for (std::size_t k = a + 1; k < b; ++k)
    std::erase_if(out, [&](int joint) {
      return std::find(track.lifted[k].begin(), track.lifted[k].end(), joint) ==
             track.lifted[k].end();
    });
  return out;
}

/// Joints of feet whose force is never more than what a sensor reads in the air, or that geometry
/// has there; and feet that stand, with a share of the weight that a swinging foot has never.
void sort_feet(const Asking& asking, const Track& track, std::size_t a, std::size_t b,
               WindowMeans& out) {
  out.in_air = lifted_in(track, a, b);
  const double weight = asking.body.mass() * eigen(asking.body.model.gravity).norm();
  for (std::size_t f = 0; f < track.feet.size(); ++f) {
    const std::vector<double>& fz = track.feet[f].fz;
    bool carries = false, stands = true;
    for (std::size_t k = a; k < b; ++k) {
      carries = carries || !(std::abs(fz[k]) < asking.stance.carries * weight);
      stands = stands && fz[k] > asking.settings.stance_share * weight;
    }
    if (!carries) out.in_air.push_back(track.feet[f].joint);
    if (stands) out.stands.push_back(f);
  }
}

}  // namespace

bool impact_near(const Track& track, std::size_t a, std::size_t b) {
  const std::size_t width = b - a, first = a - std::min(a, width),
                    last = std::min(track.impact.size(), b + width);
  return std::any_of(track.impact.begin() + static_cast<std::ptrdiff_t>(first),
                     track.impact.begin() + static_cast<std::ptrdiff_t>(last),
                     [](char impact) { return impact != 0; });
}

WindowMeans window_of(const Asking& asking, const Track& track, std::size_t a, std::size_t b) {
  // slower, a joint's direction is a part of one
  const double creeping = asking.stance.creeping;
  const auto n = static_cast<Eigen::Index>(track.joints.size());
  WindowMeans out;
  for (Vector* v : {&out.motion.q, &out.motion.dq, &out.motion.ddq, &out.sign, &out.error,
                    &out.command_rate, &out.current})
    *v = Vector::Zero(n);
  sort_feet(asking, track, a, b, out);
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

std::vector<StandingWindow> windows_of(const Asking& asking, const Eigen::VectorXd& lags) {
  std::vector<StandingWindow> out;
  for (std::size_t recording = 0; recording < asking.recordings.size(); ++recording) {
    const WholeRecording& r = asking.recordings[recording];
    const Track track = track_of(asking, r, lags);
    const auto step =
        static_cast<std::size_t>(std::max(2.0, std::round(asking.stance.window / r.interval)));
    // goals from before the recording began act in its first rows
    const auto late = static_cast<std::size_t>(std::ceil(lags.maxCoeff() / r.interval));
    for (std::size_t a = 1 + late; a + step <= r.rows(); a += step) {
      if (r.piece[a - 1] != r.piece[a + step - 1] || impact_near(track, a, a + step)) continue;
      StandingWindow window{
          recording, r.t[a], r.t[a + step - 1], window_of(asking, track, a, a + step), {}};
      const WindowMeans& w = window.means;
      if (!w.motion.acc.allFinite() || !w.error.allFinite() || !w.current.allFinite()) continue;
      for (const std::size_t foot : w.stands) window.feet.push_back(track.feet[foot]);
      out.push_back(std::move(window));
    }
  }
  return out;
}

}  // namespace sanso::diagnose
