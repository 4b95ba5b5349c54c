// Entries of z are handed out in the order of the names; what scales a figure is an exponential,
// so that no sign can change.
#include "host/learn/model/parameter_map.h"

#include <algorithm>
#include <cmath>

#include "host/learn/model/pseudo_inertia.h"
#include "shared/model/joints.h"

namespace sanso::learn {
namespace {

constexpr int kJointTypes = model::kNumJoints / 2;
constexpr const char* kJointType[kJointTypes] = {"hip_yaw", "hip_roll",  "hip_pitch",
                                                 "knee",    "ank_pitch", "ank_roll"};

// Hands out the entries of z in the order of the names.
class Reader {
 public:
  explicit Reader(const Eigen::VectorXd& z) : z_(z) {}
  double next(double deviation) { return deviation * z_[i_++]; }
  double factor(double log_deviation) { return std::exp(next(log_deviation)); }

 private:
  const Eigen::VectorXd& z_;
  Eigen::Index i_ = 0;
};

void scale_body(model::BodyInertia& body, double factor) {
  body.mass *= factor;
  for (double& v : body.inertia) v *= factor;
}

}  // namespace

ParameterMap::ParameterMap(const model::ModelParameters& initial, const ParameterPrior& prior)
    : initial_(initial), prior_(prior) {
  names_.emplace_back("stiffness");
  for (const char* type : kJointType) names_.push_back(std::string("stiffness:") + type);
  for (const char* name : {"damping", "armature", "coulomb", "torso:mass", "torso:d1", "torso:d2",
                           "torso:d3", "torso:s12", "torso:s23", "torso:s13", "torso:com_x",
                           "torso:com_y", "torso:com_z", "leg:mass", "ground:friction"}) {
    names_.emplace_back(name);
  }
  if (initial.foot.wheels) names_.emplace_back("wheels:rolling");
  if (prior.zero_rad > 0.0)
    for (const model::JointInfo& joint : model::kJoints)
      names_.push_back(std::string("zero:") + joint.name);
  if (prior.ground_height_m > 0.0) names_.emplace_back("ground:height");
  if (prior.target_lag_s > 0.0) names_.emplace_back("servo:lag");
}

model::ModelParameters ParameterMap::parameters(const Eigen::VectorXd& z) const {
  model::ModelParameters theta = initial_;
  Reader read(z);
  const double stiffness = read.factor(prior_.log_stiffness);
  double by_type[kJointTypes];
  for (double& factor : by_type) factor = stiffness * read.factor(prior_.log_stiffness_joint);
  const double damping = read.factor(prior_.log_damping),
               armature = read.factor(prior_.log_armature);
  const double coulomb = read.next(prior_.coulomb_Nm);
  for (int j = 0; j < model::kNumJoints; ++j) {
    model::ServoParameters& servo = theta.servo[j];
    servo.stiffness *= by_type[j % kJointTypes];
    servo.damping *= damping;
    servo.armature *= armature;
    servo.coulomb = std::max(0.0, servo.coulomb + coulomb);
  }

  LogCholesky torso = log_cholesky_of(initial_.body[0]);
  torso[0] += 0.5 * read.next(prior_.log_torso_mass);  // alpha is half the log of the mass
  for (const int d : {1, 2, 3}) torso[d] += read.next(prior_.log_torso_size);
  for (const int s : {4, 5, 6}) torso[s] += read.next(prior_.torso_shear);
  for (const int t : {7, 8, 9}) torso[t] += read.next(prior_.torso_com_m);
  theta.body[0] = body_of(torso);

  const double leg_mass = read.factor(prior_.log_leg_mass);
  for (int b = 1; b < model::kNumBodies; ++b) scale_body(theta.body[b], leg_mass);
  const double friction = read.factor(prior_.log_friction);
  theta.friction_forward *= initial_.foot.wheels ? read.factor(prior_.log_rolling) : friction;
  theta.friction_sideways *= friction;

  if (prior_.zero_rad > 0.0)
    for (model::ServoParameters& servo : theta.servo) servo.zero += read.next(prior_.zero_rad);
  if (prior_.ground_height_m > 0.0) theta.ground_height += read.next(prior_.ground_height_m);
  if (prior_.target_lag_s > 0.0)
    theta.target_lag_s = std::clamp(theta.target_lag_s + read.next(prior_.target_lag_s), 0.0,
                                    model::kLongestTargetLag_s);
  return theta;
}

}  // namespace sanso::learn
