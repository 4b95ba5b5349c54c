// Which parameters of the analytical model identification may change, as one standardised vector z
// around the initial model: z = 0 is the initial model, one unit of z is one prior deviation of
// that parameter.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "shared/model/step_model.h"

namespace sanso::learn {

/// Prior deviations: how far the CAD and data-sheet figures may be off. From the randomisation
/// ranges published for the servo (stiffness -30..+20 %, damping 0.8..1.2 N m s/rad) and the
/// robot's unmodelled mass (0 to 0.4 kg on the torso).
struct ParameterPrior {
  double log_stiffness = 0.25;        // common factor of all servos
  double log_stiffness_joint = 0.05;  // on top, one a joint type, left and right alike
  double log_damping = 0.25;
  double log_armature = 0.3;
  double coulomb_Nm = 0.05;  // added to the initial value, never below zero
  double log_torso_mass = 0.10;
  double torso_com_m = 0.015;
  double log_torso_size = 0.10;  // d1..d3 of the log-Cholesky factors: radii of gyration
  double torso_shear = 0.01;     // s12, s23, s13
  double log_leg_mass = 0.03;    // all leg bodies alike, shape kept
  double log_friction = 0.3;     // of the ground
  double log_rolling = 0.7;      // of wheels along their way: 0.005 .. 0.03 is what there is
  // how the robot was put together, placed and connected, last in z; 0: as drawn, with no entry
  double zero_rad = 0.0122;        // of each joint: 0.7 deg, a horn put on by hand
  double ground_height_m = 0.003;  // plates, rubber, a camera's own origin
  double target_lag_s = 0.010;     // bus, servo loop and what filters its readings
};

/// The same without entries for how the robot was put together, placed and connected.
constexpr ParameterPrior as_drawn(ParameterPrior prior) {
  prior.zero_rad = prior.ground_height_m = prior.target_lag_s = 0.0;
  return prior;
}

/// z (size()) to parameters and back; holds the initial parameters.
class ParameterMap {
 public:
  explicit ParameterMap(const model::ModelParameters& initial, const ParameterPrior& prior = {});
  /// How many numbers a z has; each is in prior deviations, 0: as initially.
  Eigen::Index size() const { return static_cast<Eigen::Index>(names_.size()); }
  const ParameterPrior& prior() const { return prior_; }
  /// Around the same initial parameters, with other deviations.
  ParameterMap with(const ParameterPrior& prior) const { return ParameterMap(initial_, prior); }
  const std::vector<std::string>& names() const { return names_; }
  /// Physically consistent for every finite z.
  model::ModelParameters parameters(const Eigen::VectorXd& z) const;

 private:
  model::ModelParameters initial_;
  ParameterPrior prior_;
  std::vector<std::string> names_;
};

}  // namespace sanso::learn
