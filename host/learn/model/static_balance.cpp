// Residuals of all poses over their expected errors, a Gauss-Newton search with the priors as
// springs, and once more with the dry friction that the scatter shows.
#include "host/learn/model/static_balance.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "shared/model/joints.h"
#include "shared/model/op3_kinematics.h"
#include "shared/model/step_model.h"

namespace sanso::learn {
namespace {

using math::Mat3;
using math::Vec3;

constexpr int kWays = 6;           // of the trunk above feet that stay
constexpr int kSoleEquations = 5;  // two normals and a difference of heights
constexpr int kEquations = kWays + kSoleEquations;
constexpr int kTilts = 4;  // IMU roll, pitch; floor roll, pitch

/// What is not of the model itself, in its units.
struct Placement {
  Vec3 imu_tilt_rad = Vec3::Zero();
  Vec3 floor_tilt_rad = Vec3::Zero();
  model::Input leaning_Nm = model::Input::Zero();
};

Placement placement_of(const Eigen::VectorXd& p, Eigen::Index first,
                       const StaticBalanceSettings& s) {
  Placement out;
  out.imu_tilt_rad.head<2>() = s.imu_tilt_rad * p.segment<2>(first);
  out.floor_tilt_rad.head<2>() = s.floor_tilt_rad * p.segment<2>(first + 2);
  out.leaning_Nm = s.leaning_Nm * p.segment<model::kNumJoints>(first + kTilts);
  return out;
}

/// The robot as it stands when the figures of `model` and `placement` are true.
model::State true_state(const model::State& reported, const model::StepModel& model,
                        const Placement& placement) {
  model::State x = reported;
  for (int j = 0; j < model::kNumJoints; ++j) x[model::kXJoint + j] -= model.servo[j].zero;
  x.segment<4>(model::kXQuat) =
      math::quat_plus(model::base_quat(reported), -placement.imu_tilt_rad);
  return x;
}

/// Joint rates for the trunk's six ways (three of its origin along the world's axes, three turns
/// about its own) with both feet in place: 12 x 6.
Eigen::Matrix<double, model::kNumJoints, kWays> rates_with_feet_in_place(
    const model::Kinematics& kin) {
  Eigen::Matrix<double, model::kNumJoints, kWays> rates;
  for (int foot = 0; foot < model::kNumFeet; ++foot) {
    const int body = model::foot_body(foot), first = 6 * foot;
    Eigen::Matrix<double, 6, model::kNv> J;
    J << model::point_jacobian(kin, body, kin.p_world_link[body]),
        model::rotation_jacobian(kin, body);
    const Eigen::Matrix<double, 6, 6> leg = J.middleCols<6>(6 + first);
    rates.middleRows<6>(first) = -leg.partialPivLu().solve(J.leftCols<6>());
  }
  return rates;
}

/// dV/d(way) [N, N m]: how the weight rises.
Eigen::Matrix<double, kWays, 1> weight_along(
    const model::StepModel& model, const model::Kinematics& kin,
    const Eigen::Matrix<double, model::kNumJoints, kWays>& rates) {
  Eigen::Matrix<double, 1, model::kNv> rise = Eigen::Matrix<double, 1, model::kNv>::Zero();
  for (int b = 0; b < model::kNumBodies; ++b) {
    const model::StepModel::Body& body = model.body[b];
    const Vec3 com(body.first_moment[0], body.first_moment[1], body.first_moment[2]);
    const Vec3 p = model::point_in_world(kin, b, com / body.mass);
    rise += model::kGravity_m_s2 * body.mass * model::point_jacobian(kin, b, p).row(2);
  }
  return (rise.leftCols<kWays>() + rise.rightCols<model::kNumJoints>() * rates).transpose();
}

Eigen::Matrix<double, kSoleEquations, 1> sole_residuals(const model::Kinematics& kin,
                                                        const Vec3& floor_tilt_rad) {
  const Mat3 R_floor_world = math::rotation_matrix(math::quat_exp(floor_tilt_rad)).transpose();
  Vec3 up[model::kNumFeet], centre[model::kNumFeet];
  for (int foot = 0; foot < model::kNumFeet; ++foot) {
    const int body = model::foot_body(foot);
    up[foot] = R_floor_world * kin.R_world_link[body].col(2);
    centre[foot] =
        R_floor_world * model::point_in_world(kin, body, model::sole_centre_in_foot(foot));
  }
  Eigen::Matrix<double, kSoleEquations, 1> r;
  r << up[0].head<2>(), up[1].head<2>(), centre[1][2] - centre[0][2];
  return r;
}

/// Residuals of one pose, [work 6 | soles 5].
Eigen::Matrix<double, kEquations, 1> residuals_of(const HeldPose& pose,
                                                  const model::StepModel& model,
                                                  const Placement& placement) {
  model::Kinematics kin;
  model::forward_kinematics(true_state(pose.x, model, placement), kin);
  const auto rates = rates_with_feet_in_place(kin);
  model::Input torque;  // the servo knows its own zero: reported angle against target
  for (int j = 0; j < model::kNumJoints; ++j)
    torque[j] = model.servo[j].stiffness * (pose.u[j] - pose.x[model::kXJoint + j]) +
                placement.leaning_Nm[j];
  Eigen::Matrix<double, kEquations, 1> r;
  r << rates.transpose() * torque - weight_along(model, kin, rates),
      sole_residuals(kin, placement.floor_tilt_rad);
  return r;
}

/// All poses against one set of parameters.
class Problem {
 public:
  Problem(std::span<const HeldPose> poses, const ParameterMap& map,
          const StaticBalanceSettings& settings)
      : poses_(poses), map_(map), settings_(settings) {
    for (const HeldPose& pose : poses_) {
      model::Kinematics kin;
      model::forward_kinematics(pose.x, kin);
      const auto rates = rates_with_feet_in_place(kin);
      const Eigen::Matrix<double, kWays, kWays> spread = rates.transpose() * rates;
      unit_friction_.push_back(spread.llt().matrixL());
    }
  }
  Eigen::Index size() const { return map_.size() + model::kNumJoints + kTilts; }

  /// Over their expected errors; joints at rest lean on `friction_Nm` each.
  Eigen::VectorXd residuals(const Eigen::VectorXd& p, double friction_Nm) const {
    const model::StepModel model = model::make_step_model(map_.parameters(p.head(map_.size())));
    const Placement placement = placement_of(p, map_.size(), settings_);
    Eigen::VectorXd r(kEquations * std::ssize(poses_));
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      Eigen::Matrix<double, kEquations, 1> of_pose = residuals_of(poses_[i], model, placement);
      const Eigen::Matrix<double, kWays, 1> work = of_pose.head<kWays>();
      of_pose.head<kWays>() =
          unit_friction_[i].triangularView<Eigen::Lower>().solve(work) / friction_Nm;
      of_pose.segment<4>(kWays) /= settings_.sole_rad;
      of_pose[kEquations - 1] /= settings_.sole_height_m;
      r.segment<kEquations>(kEquations * static_cast<Eigen::Index>(i)) = of_pose;
    }
    return r;
  }

  Eigen::MatrixXd slope(const Eigen::VectorXd& p, double friction_Nm) const {
    constexpr double kStep = 1e-4;  // of a prior deviation
    Eigen::MatrixXd J(kEquations * std::ssize(poses_), size());
    for (Eigen::Index i = 0; i < size(); ++i) {
      Eigen::VectorXd ahead = p, behind = p;
      ahead[i] += kStep;
      behind[i] -= kStep;
      J.col(i) = (residuals(ahead, friction_Nm) - residuals(behind, friction_Nm)) / (2.0 * kStep);
    }
    return J;
  }

  /// Root mean square of the work's residuals, 1 when the joints lean on friction as expected.
  static double scatter(const Eigen::VectorXd& residuals) {
    double sum = 0.0;
    const Eigen::Index poses = residuals.size() / kEquations;
    for (Eigen::Index i = 0; i < poses; ++i)
      sum += residuals.segment<kWays>(kEquations * i).squaredNorm();
    return std::sqrt(sum / static_cast<double>(kWays * poses));
  }

 private:
  std::span<const HeldPose> poses_;
  const ParameterMap& map_;
  const StaticBalanceSettings& settings_;
  std::vector<Eigen::Matrix<double, kWays, kWays>> unit_friction_;  // lower factors
};

/// Moves `p` to the most probable parameters; returns their covariance.
Eigen::MatrixXd search(const Problem& problem, double friction_Nm, Eigen::VectorXd& p) {
  constexpr int kSteps = 6;  // nearly linear: three are usual
  Eigen::MatrixXd information;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::VectorXd r = problem.residuals(p, friction_Nm);
    const Eigen::MatrixXd J = problem.slope(p, friction_Nm);
    information = J.transpose() * J + Eigen::MatrixXd::Identity(p.size(), p.size());
    const Eigen::VectorXd way = information.llt().solve(-(J.transpose() * r + p));
    p += way;
    if (way.norm() < 1e-6) break;
  }
  return information.inverse();
}

}  // namespace

StaticBalance balance_of(std::span<const HeldPose> poses, const ParameterMap& map,
                         const StaticBalanceSettings& settings) {
  if (poses.empty()) throw std::invalid_argument("static balance: no pose was held");
  const Problem problem(poses, map, settings);
  StaticBalance out;
  out.mean = Eigen::VectorXd::Zero(problem.size());
  out.friction_Nm = settings.friction_Nm;
  // many parameters make a small scatter: it may only say that the joints lean on more
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    out.covariance = search(problem, out.friction_Nm, out.mean);
    const double scatter = Problem::scatter(problem.residuals(out.mean, out.friction_Nm));
    out.friction_Nm = std::max(settings.friction_Nm, out.friction_Nm * scatter);
  }
  out.covariance = search(problem, out.friction_Nm, out.mean);
  return out;
}

}  // namespace sanso::learn
