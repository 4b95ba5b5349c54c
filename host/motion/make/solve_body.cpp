// The whole body from feet, base height and a path on the ground: base by the CoM, legs by inverse
// kinematics.
#include <cmath>

#include "host/motion/make/balance.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/leg_ik.h"
#include "host/motion/make/retarget.h"
#include "host/motion/mocap/filter.h"
#include "shared/base/time.h"

namespace sanso::motion {
namespace {

constexpr int kCentrePasses = 3;    // base against CoM; the third moves it by less than 0.1 mm
constexpr int kZmpPasses = 3;       // pendulum against the bodies' ZMP
constexpr double kSmooth_Hz = 5.0;  // of the ZMP reference: 40-80 ms

using Path = std::array<std::vector<double>, 2>;  // x and y over the ticks

/// Poses of the whole body for a given base path; returns the largest reach.
double solve_poses(const BodyTarget& target, const Path& base, Trajectory& trajectory) {
  double reach = 0.0;
  const std::size_t n = target.ground.size();
  trajectory.dt_s = kTick_s;
  trajectory.x.assign(n, model::neutral_state());
  for (std::size_t k = 0; k < n; ++k) {
    model::State& x = trajectory.x[k];
    x.head<3>() = math::Vec3(base[0][k], base[1][k], target.base_height[k]);
    for (int side : {kRight, kLeft}) {
      const math::Mat3 R_world_foot =
          target.foot_pitch.empty() ? math::Mat3::Identity() : pitched(target.foot_pitch[k][side]);
      const LegSolution leg = solve_leg(side, model::base_position(x), math::Mat3::Identity(),
                                        target.p_world_foot[k][side], R_world_foot);
      x.segment<6>(model::kXJoint + 6 * side) = leg.q;
      reach = std::max(reach, leg.reach);
    }
  }
  return reach;
}

/// Moves the base until the CoM is on `com`; the trajectory then holds the poses.
double follow_com(const BodyTarget& target, const Path& com, Path& base, Trajectory& trajectory) {
  double reach = solve_poses(target, base, trajectory);
  for (int pass = 0; pass < kCentrePasses; ++pass) {
    for (std::size_t k = 0; k < trajectory.x.size(); ++k) {
      const math::Vec3 centre = body_points(trajectory.x[k]).centre_of_mass();
      for (int axis : {0, 1}) base[axis][k] += com[axis][k] - centre[axis];
    }
    reach = solve_poses(target, base, trajectory);
  }
  return reach;
}

}  // namespace

math::Mat3 pitched(double rad) {
  math::Mat3 R;
  R << std::cos(rad), 0.0, std::sin(rad), 0.0, 1.0, 0.0, -std::sin(rad), 0.0, std::cos(rad);
  return R;
}

Retargeted solve_body(const BodyTarget& target) {
  Retargeted out;
  out.target = target;
  const std::size_t n = target.ground.size();
  Path wanted;
  for (int axis : {0, 1}) {
    for (const auto& p : target.ground) wanted[axis].push_back(p[axis]);
    wanted[axis] = low_pass(wanted[axis], kTick_s, kSmooth_Hz);
  }
  Path base = wanted, com = wanted;
  out.reach = follow_com(target, com, base, out.trajectory);
  if (!target.ground_is_com) {
    // the pendulum is a point mass; legs are not. What the bodies' ZMP misses is added to the
    // pendulum's reference.
    Path zmp = wanted;
    const double height = body_points(out.trajectory.x.front()).centre_of_mass().z();
    for (int pass = 0; pass < kZmpPasses; ++pass) {
      for (int axis : {0, 1}) com[axis] = com_for_zmp(zmp[axis], height, kTick_s);
      out.reach = follow_com(target, com, base, out.trajectory);
      const std::vector<ZmpSample> real = zmp_of(out.trajectory);
      for (int axis : {0, 1}) {
        std::vector<double> missing(n);
        for (std::size_t k = 0; k < n; ++k)
          missing[k] = wanted[axis][k] - (axis == 0 ? real[k].x : real[k].y);
        const std::vector<double> correction = low_pass(missing, kTick_s, kSmooth_Hz);
        for (std::size_t k = 1; k + 1 < n; ++k) zmp[axis][k] += correction[k];
      }
    }
  }
  differentiate_poses(out.trajectory);
  return out;
}

}  // namespace sanso::motion
