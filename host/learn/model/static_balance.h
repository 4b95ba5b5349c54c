// What a robot shows by standing still. Of a pose that is held with both soles flat on the floor
// are known: the servos' targets, the joints as they report them, and how the trunk leans by the
// IMU.
//
//   work      moved with its feet in place, the robot stores what the servos do: for each of the
//             six ways in which the trunk can move, sum of q_j' K (u - q)_j = dV / d(way). No force
//             of the ground stands in it, however the two feet share the weight
//   soles     are parallel to the floor and equally high: five equations
//
// Unknown are the parameters of identification (ParameterMap; joint zeros are among them), a tilt
// of the IMU in the trunk and one of the floor; all with their priors, by Gauss-Newton.
// Standing shows no scale of forces: stiffness over mass is found, neither of them. Nor does it
// tell offsets apart that lie on one axis, tilts of IMU and floor, or how turned a foot is: what is
// found is their sum, shared out by the priors.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/learn/model/parameter_map.h"
#include "shared/model/state_layout.h"

namespace sanso::learn {

/// A pose as it was held: means over a quiet stretch. Of x count the joints [rad, as the servos
/// report them] and the base's orientation [as the IMU reports it].
struct HeldPose {
  model::State x = model::neutral_state();
  model::Input u = model::Input::Zero();  // targets as sent, rad
};

struct StaticBalanceSettings {
  double friction_Nm = 0.1;
  double leaning_Nm = 0.1;
  double imu_tilt_rad = 0.006;
  double floor_tilt_rad = 0.009;
  double sole_rad = 0.004;
  double sole_height_m = 0.001;

  constexpr void visit(auto&& field) {
    field(
        "friction_Nm", friction_Nm, "N m", 0.001, 5.0,
        "a joint that has come to rest may lean on so much dry friction; the scatter corrects it");
    field("leaning_Nm", leaning_Nm, "N m", 0.0, 5.0,
          "and on so much in the same direction in all poses, of which no scatter tells");
    field("imu_tilt_rad", imu_tilt_rad, "rad", 0.0, 0.2,
          "prior deviation of the sensor's mounting and of its static error, roll and pitch");
    field("floor_tilt_rad", floor_tilt_rad, "rad", 0.0, 0.2,
          "prior deviation of the floor's roll and pitch: half a degree");
    field("sole_rad", sole_rad, "rad", 0.0001, 0.2,
          "a sole that stands is parallel to the floor within this: rubber, and encoder counts");
    field("sole_height_m", sole_height_m, "m", 0.0001, 0.02,
          "two soles that stand are equally high within this: rubber gives way");
  }
};

/// Parameters in prior deviations, in this order: z of the ParameterMap, IMU tilt (roll, pitch:
/// what it reports is the trunk's orientation turned by this), floor tilt (roll, pitch), and the
/// dry friction that each of twelve joints leans on in all poses.
struct StaticBalance {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  double friction_Nm = 0.0;  // as the scatter of the poses shows it

  /// The part that a ParameterMap turns into parameters.
  Eigen::VectorXd z(const ParameterMap& map) const { return mean.head(map.size()); }
};

/// One figure in its own unit, before and after the poses were seen.
struct StaticFigure {
  std::string name, unit;
  double value = 0.0, deviation = 0.0;  // standard deviation
  double prior_value = 0.0, prior_deviation = 0.0;
  /// The poses tell something of it.
  bool seen() const { return deviation < 0.9 * prior_deviation; }
};

/// What the poses show, as parameters that make all of them balance. Throws std::invalid_argument
/// without poses.
StaticBalance balance_of(std::span<const HeldPose> poses, const ParameterMap& map,
                         const StaticBalanceSettings& settings);

/// Stiffness over mass, centre of mass, offsets and tilts with their deviations. Names stay.
std::vector<StaticFigure> figures_of(const StaticBalance& balance, const ParameterMap& map,
                                     const StaticBalanceSettings& settings);

}  // namespace sanso::learn
