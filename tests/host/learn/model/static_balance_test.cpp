// Poses in which a robot of known parameters has come to rest give these parameters back. The robot
// is the planner's own step, run until nothing moves: it finds its balance by contact and springs,
// not by the equations of the regression.
#include "host/learn/model/static_balance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/learn/session/bring_up.h"
#include "shared/model/op3_step.h"

namespace sanso::learn {
namespace {

/// A robot that is not as the initial model believes.
struct Other {
  double stiffness = 1.0;                       // of the initial
  math::Vec3 torso_com_m = math::Vec3::Zero();  // shift
  double torso_mass_kg = 0.0;                   // more
  model::Input zero_offset_rad = model::Input::Zero();

  model::ModelParameters parameters() const {
    model::ModelParameters theta = model::nominal_parameters();
    for (model::ServoParameters& servo : theta.servo) servo.stiffness *= stiffness;
    for (int i = 0; i < 3; ++i) theta.body[0].com[i] += torso_com_m[i];
    theta.body[0].mass += torso_mass_kg;
    return theta;
  }
};

/// Where it rests when its servos are told to be at `target`, and what they report there.
HeldPose rest(const Other& other, const model::State& target) {
  const model::StepModel model = model::make_step_model(other.parameters());
  const model::Ground ground;
  model::StepScratch scratch;
  HeldPose pose;
  pose.u = model::joints(target);
  const model::Input u_true = pose.u - other.zero_offset_rad;
  pose.x = target;
  for (int step = 0; step < 400; ++step)
    model::analytical_step(model, ground, pose.x.data(), u_true.data(), 0.03, 1, pose.x.data(),
                           scratch);
  EXPECT_LT(pose.x.tail<model::kNv>().norm(), 1e-3) << "the premise: it has come to rest";
  pose.x.segment<model::kNumJoints>(model::kXJoint) += other.zero_offset_rad;
  return pose;
}

std::vector<HeldPose> held_by(const Other& other) {
  std::vector<HeldPose> poses;
  for (const TrunkShift& shift : bring_up_poses({}))
    poses.push_back(rest(other, shifted_stand(shift)));
  return poses;
}

class Found {
 public:
  explicit Found(const Other& other)
      : balance_(balance_of(held_by(other), map_, settings_)),
        figures_(figures_of(balance_, map_, settings_)) {}
  const StaticFigure& operator[](const std::string& name) const {
    for (const StaticFigure& f : figures_)
      if (f.name == name) return f;
    throw std::out_of_range(name);
  }
  const StaticBalance& balance() const { return balance_; }
  const ParameterMap& map() const { return map_; }

 private:
  ParameterMap map_{model::nominal_parameters()};
  StaticBalanceSettings settings_;
  StaticBalance balance_;
  std::vector<StaticFigure> figures_;
};

double total_mass(const model::ModelParameters& theta) {
  return model::make_step_model(theta).body[0].subtree_mass;
}

TEST(StaticBalance, StiffnessOverMassAndCentreOfMassAreFound) {
  for (const Other& other :
       {Other{0.7, {-0.015, 0.004, 0.0}, 0.0}, Other{1.2, {0.012, -0.003, 0.0}, 0.3},
        Other{0.85, {0.0, 0.0, 0.0}, 0.0}}) {
    const Found found(other);
    const model::ModelParameters truth = other.parameters();
    const double ratio =
        other.stiffness * total_mass(model::nominal_parameters()) / total_mass(truth);
    EXPECT_NEAR(found["stiffness_over_mass"].value, ratio, 0.03 * ratio);
    EXPECT_LT(found["stiffness_over_mass"].deviation, 0.1);
    const double shift_share = truth.body[0].mass / total_mass(truth);
    const double heavier = other.torso_mass_kg / total_mass(truth);
    const StaticFigure& x = found["com_x"];
    const StaticFigure& y = found["com_y"];
    // the heavier torso also pulls the robot's centre towards its own, 1 mm behind at most
    EXPECT_NEAR(x.value - x.prior_value, shift_share * other.torso_com_m[0],
                0.0015 + 0.01 * heavier);
    EXPECT_NEAR(y.value - y.prior_value, shift_share * other.torso_com_m[1], 0.0015);
  }
}

TEST(StaticBalance, TheScaleOfAllForcesStaysWithItsPrior) {
  const Found found(Other{0.8, {0.0, 0.0, 0.0}, 0.0});
  EXPECT_FALSE(found["mass"].seen()) << "twice the mass on twice the stiffness stands alike";
  EXPECT_TRUE(found["stiffness_over_mass"].seen());
}

TEST(StaticBalance, ZeroOffsetsAreSeenAsTheTurnOfASole) {
  Other other;
  other.zero_offset_rad[4] = 0.03;   // right ankle pitch
  other.zero_offset_rad[9] = -0.02;  // left knee
  other.zero_offset_rad[11] = 0.02;  // left ankle roll
  const Found found(other);
  EXPECT_NEAR(found["sole:right_pitch"].value - found["sole:left_pitch"].value, 0.03 + 0.02, 0.008);
  EXPECT_NEAR(found["sole:left_roll"].value - found["sole:right_roll"].value, 0.02, 0.008);
  EXPECT_TRUE(found["sole:right_pitch"].seen());
  EXPECT_FALSE(found["zero:r_hip_yaw"].seen()) << "no sole shows how it is turned";
}

TEST(StaticBalance, ModelFromTheNominalRobotIsTheNominalModel) {
  const Found found(Other{});
  EXPECT_LT(found.balance().z(found.map()).cwiseAbs().maxCoeff(), 0.15);
}

TEST(StaticBalance, WithoutAPoseThereIsNoAnswer) {
  const ParameterMap map(model::nominal_parameters());
  EXPECT_THROW(balance_of({}, map, {}), std::invalid_argument);
}

}  // namespace
}  // namespace sanso::learn
