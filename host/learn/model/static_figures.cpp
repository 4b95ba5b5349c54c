// The answer in units that a person knows: each figure is a function of the parameters, its
// deviation that of the function's slope.
#include <algorithm>
#include <cmath>
#include <functional>

#include "host/learn/model/static_balance.h"
#include "shared/model/joints.h"
#include "shared/model/op3_kinematics.h"

namespace sanso::learn {
namespace {

using FigureOf = std::function<double(const Eigen::VectorXd& parameters)>;

StaticFigure figure(const std::string& name, const char* unit, const StaticBalance& balance,
                    const FigureOf& of) {
  constexpr double kStep = 1e-4;  // of a prior deviation
  const Eigen::VectorXd& mean = balance.mean;
  const Eigen::VectorXd prior_mean = Eigen::VectorXd::Zero(mean.size());
  Eigen::VectorXd slope(mean.size()), prior_slope(mean.size());
  for (Eigen::Index i = 0; i < mean.size(); ++i) {
    const Eigen::VectorXd way = kStep * Eigen::VectorXd::Unit(mean.size(), i);
    slope[i] = (of(mean + way) - of(mean - way)) / (2.0 * kStep);
    prior_slope[i] = (of(prior_mean + way) - of(prior_mean - way)) / (2.0 * kStep);
  }
  return {name,           unit,
          of(mean),       std::sqrt(std::max(0.0, slope.dot(balance.covariance * slope))),
          of(prior_mean), prior_slope.norm()};
}

/// The robot's figures that parameters of the model make.
class Robot {
 public:
  explicit Robot(const ParameterMap& map) : map_(map), initial_(theta(Eigen::VectorXd())) {
    initial_mass_ = mass(initial_);
  }
  model::ModelParameters theta(const Eigen::VectorXd& p) const {
    const Eigen::Index n = map_.size();
    return map_.parameters(p.size() < n ? Eigen::VectorXd(Eigen::VectorXd::Zero(n))
                                        : Eigen::VectorXd(p.head(n)));
  }
  static double mass(const model::ModelParameters& theta) {
    return model::make_step_model(theta).body[0].subtree_mass;
  }
  /// Geometric mean over the joints, against the initial model.
  double stiffness_over_mass(const Eigen::VectorXd& p) const {
    const model::ModelParameters now = theta(p);
    double log_stiffness = 0.0;
    for (int j = 0; j < model::kNumJoints; ++j)
      log_stiffness += std::log(now.servo[j].stiffness / initial_.servo[j].stiffness);
    return std::exp(log_stiffness / model::kNumJoints) * initial_mass_ / mass(now);
  }
  /// Of the whole robot in the maker's standing pose, base axes, m.
  math::Vec3 centre_of_mass(const Eigen::VectorXd& p) const {
    const model::State stand = model::standing_state();
    model::Kinematics kin;
    model::forward_kinematics(stand, kin);
    return model::centre_of_mass(model::make_step_model(theta(p)), kin) -
           model::base_position(stand);
  }

 private:
  const ParameterMap& map_;
  model::ModelParameters initial_;
  double initial_mass_ = 1.0;
};

/// How a sole is turned against the trunk by the zeros of its leg's joints about this axis [rad].
double turned_sole(const model::ModelParameters& theta, int foot, int axis) {
  double sum = 0.0;
  for (int j = 6 * foot; j < 6 * foot + 6; ++j)
    if (model::kOp3Joints[j].axis == axis) sum += model::kOp3Joints[j].sign * theta.servo[j].zero;
  return sum;
}

}  // namespace

std::vector<StaticFigure> figures_of(const StaticBalance& balance, const ParameterMap& map,
                                     const StaticBalanceSettings& settings) {
  const Robot robot(map);
  std::vector<StaticFigure> out;
  const auto add = [&](const std::string& name, const char* unit, const FigureOf& of) {
    out.push_back(figure(name, unit, balance, of));
  };
  add("stiffness_over_mass", "initial",
      [&](const auto& p) { return robot.stiffness_over_mass(p); });
  add("mass", "kg", [&](const auto& p) { return Robot::mass(robot.theta(p)); });
  for (int axis = 0; axis < 3; ++axis)
    add(std::string("com_") + "xyz"[axis], "m",
        [&robot, axis](const auto& p) { return robot.centre_of_mass(p)[axis]; });
  const Eigen::Index tilts = map.size();
  for (int foot = 0; foot < model::kNumFeet; ++foot)
    for (int axis = 0; axis < 2; ++axis)
      add(std::string("sole:") + (foot == model::kRightFoot ? "right" : "left") +
              (axis == 0 ? "_roll" : "_pitch"),
          "rad",
          [&robot, foot, axis](const auto& p) { return turned_sole(robot.theta(p), foot, axis); });
  for (int j = 0; j < model::kNumJoints; ++j)
    add(std::string("zero:") + model::kJoints[static_cast<std::size_t>(j)].name, "rad",
        [&robot, j](const auto& p) { return robot.theta(p).servo[j].zero; });
  constexpr const char* kTilt[4] = {"imu_roll", "imu_pitch", "floor_roll", "floor_pitch"};
  for (int t = 0; t < 4; ++t)
    add(kTilt[t], "rad", [&settings, tilts, t](const auto& p) {
      return (t < 2 ? settings.imu_tilt_rad : settings.floor_tilt_rad) * p[tilts + t];
    });
  return out;
}

}  // namespace sanso::learn
