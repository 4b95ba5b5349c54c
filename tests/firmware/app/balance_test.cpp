// The ankles' answer to lean while holding: its signs and gains, on the one-step model.
#include "firmware/lower/balance.h"

#include <gtest/gtest.h>

#include "shared/model/op3_step.h"

namespace sanso::firmware {
namespace {

model::Input standing_pose() {
  model::Input q;
  q << 0, 0, 0.56, -1.13, -0.57, 0, 0, 0, -0.56, 1.13, 0.57, 0;
  return q;
}

/// Largest lean [rad] in three seconds of holding on the model with servos of `stiffness` times the
/// nominal and a trunk whose weight sits `back_m` further back and `right_m` to the right.
double largest_lean(const SupervisorSettings& settings, double stiffness, double back_m,
                    double right_m) {
  model::ModelParameters theta = model::nominal_parameters();
  for (auto& servo : theta.servo) servo.stiffness *= stiffness;
  theta.body[0].com[0] -= back_m;
  theta.body[0].com[1] -= right_m;
  const model::StepModel robot = model::make_step_model(theta);
  model::State x = model::neutral_state();
  x[2] = 0.245;
  x.segment<model::kNumJoints>(model::kXJoint) = standing_pose();
  model::StepScratch scratch;
  double largest = 0.0;
  for (int tick = 0; tick < 300; ++tick) {
    const model::Input u = standing_pose() + balance_correction(x, Lean{}, settings);
    model::analytical_step(robot, model::make_plane(), x.data(), u.data(), 0.01, 1, x.data(),
                           scratch);
    const Lean lean = lean_of(x);
    largest = std::max(largest, std::hypot(lean.pitch, lean.roll));
  }
  return largest;
}

SupervisorSettings without_balance() {
  SupervisorSettings s;
  s.balance_pitch_gain = s.balance_roll_gain = 0.0;
  return s;
}

TEST(Balance, HoldsARobotThatFallsWithoutIt) {
  constexpr double kSoft = 0.8, kBack_m = 0.025;
  EXPECT_GT(largest_lean(without_balance(), kSoft, kBack_m, 0.0), 1.0) << "the premise";
  EXPECT_LT(largest_lean(SupervisorSettings{}, kSoft, kBack_m, 0.0), 0.3);
}

TEST(Balance, LessensTheLeanToEverySide) {
  for (const double back : {-0.01, 0.01})
    for (const double right : {-0.01, 0.01})
      EXPECT_LT(largest_lean(SupervisorSettings{}, 0.8, back, right),
                largest_lean(without_balance(), 0.8, back, right))
          << back << " m back, " << right << " m to the right";
}

TEST(Balance, AnswersGravityWithAsMuchAsItTopples) {
  const model::ModelParameters theta = model::nominal_parameters();
  double mass = 0.0;
  for (const auto& body : theta.body) mass += body.mass;
  constexpr double kHeight_m = 0.2;  // of the centre of mass above the ankles of a standing OP3
  constexpr int kAnkPitch = 4;
  const double needed = mass * 9.81 * kHeight_m / (2.0 * theta.servo[kAnkPitch].stiffness);
  const SupervisorSettings s;
  EXPECT_GT(s.balance_pitch_gain, needed);
  EXPECT_LT(s.balance_pitch_gain, 1.5 * needed) << "more would fight the delay of the loop";
  EXPECT_EQ(s.balance_roll_gain, s.balance_pitch_gain);
}

TEST(Balance, IsSilentInThePoseItself) {
  model::State x = model::neutral_state();
  x.segment<4>(model::kXQuat) = math::quat_exp(math::Vec3(0.0, 0.2, 0.0));
  EXPECT_EQ(balance_correction(x, lean_of(x), SupervisorSettings{}), model::Input::Zero());
  EXPECT_GT(balance_correction(x, Lean{}, SupervisorSettings{}).norm(), 0.01);
}

}  // namespace
}  // namespace sanso::firmware
