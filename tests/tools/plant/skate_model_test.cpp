// The planner's step on skates against the emulated robot's physics: the same start and the same
// held targets, along flat floor and ramp. Each side has figures and code of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "shared/grounds/ground_file.h"
#include "shared/model/op3_kinematics.h"
#include "shared/model/op3_step.h"
#include "tools/plant/mjcf.h"
#include "tools/plant/plant.h"

namespace sanso {
namespace {

constexpr int kLegIds[model::kNumJoints] = {7, 9, 11, 13, 15, 17, 8, 10, 12, 14, 16, 18};

std::array<double, plant::kNumServos> crouched() {
  std::array<double, plant::kNumServos> q{};
  constexpr double kArms_deg[6] = {4.92, -5.01, -45.62, 45.35, 45.18, -45.35};  // walkready
  for (std::size_t i = 0; i < 6; ++i) q[i] = kArms_deg[i] * plant::kPi / 180;
  q[10] = 0.55, q[11] = -0.55, q[12] = -1.06, q[13] = 1.06, q[14] = -0.60, q[15] = 0.60;
  return q;
}

void run(plant::Plant& robot, double seconds) {
  const auto q = crouched();
  for (long k = std::lround(seconds / plant::kPhysicsStep_s); k > 0; --k) {
    // 70 % of the maker's gain, as model and controller have it
    for (int i = 0; i < plant::kNumServos; ++i)
      robot.set_duty(i, 3.223 * (q[i] - robot.link_angle(i)));
    robot.step();
  }
}

model::State state_of(const plant::Plant& robot) {
  model::State x;
  const plant::BaseMotion base = robot.base();
  for (int i = 0; i < 3; ++i) {
    x[model::kXPos + i] = base.p_world_base[i];
    x[model::kXVel + i] = base.v_base_in_world[i];
    x[model::kXOmega + i] = base.w_base_in_base[i];
  }
  for (int i = 0; i < 4; ++i) x[model::kXQuat + i] = base.quat_world_base[i];
  for (int j = 0; j < model::kNumJoints; ++j) {
    x[model::kXJoint + j] = robot.link_angle(kLegIds[j] - 1);
    x[model::kXJointRate + j] = robot.link_rate(kLegIds[j] - 1);
  }
  return x;
}

struct Errors {
  double place_m = 0, height_m = 0, pitch_rad = 0, speed_m_s = 0;
};

/// Largest errors of predictions over 0.66 s, begun every 60 ms while the robot is before `end`.
Errors errors_on(const std::string& ground, double start_x, double end) {
  plant::World world = plant::load_world("nominal+" + ground + "+wheels");
  plant::Plant robot(world);
  robot.place(crouched(), start_x, 0, 0);
  run(robot, 0.3);
  robot.set_push({4, 0, 0}, {0, 0, 0});
  run(robot, 0.3);
  robot.set_push({0, 0, 0}, {0, 0, 0});
  run(robot, 0.1);
  std::vector<model::State> seen;
  for (int k = 0; k < 60; ++k) {
    seen.push_back(state_of(robot));
    run(robot, 0.06);
  }
  model::ModelParameters theta = model::skating_parameters();
  theta.friction_forward =
      8 * world.wheels.bearing_Nm / world.wheels.radius_m / (robot.mass_kg() * 9.81);
  const model::StepModel step_model = model::make_step_model(theta);
  const model::Ground profile = grounds::load_ground(ground);
  model::Input u;
  for (int j = 0; j < model::kNumJoints; ++j) u[j] = crouched()[kLegIds[j] - 1];
  Errors worst;
  constexpr std::size_t kAhead = 11;
  for (std::size_t from = 0; from + kAhead < seen.size(); ++from) {
    if (seen[from][0] > end) break;
    model::State x = seen[from];
    model::StepScratch scratch;
    for (std::size_t k = 0; k < kAhead; ++k)
      model::analytical_step(step_model, profile, x.data(), u.data(), 0.06, 1, x.data(), scratch);
    const model::Tangent e = model::minus(x, seen[from + kAhead]);
    worst.place_m = std::max(worst.place_m, std::abs(e[0]));
    worst.height_m = std::max(worst.height_m, std::abs(e[2]));
    worst.pitch_rad = std::max(worst.pitch_rad, std::abs(e[model::kDTheta + 1]));
    worst.speed_m_s = std::max(worst.speed_m_s, std::abs(e[model::kDVel]));
  }
  std::printf("%s: place %.1f mm, height %.1f mm, pitch %.1f mrad, speed %.3f m/s\n",
              ground.c_str(), 1e3 * worst.place_m, 1e3 * worst.height_m, 1e3 * worst.pitch_rad,
              worst.speed_m_s);
  return worst;
}

TEST(SkateModel, CoastsOnTheFlatLikeThePlant) {
  const Errors e = errors_on("plane", 0.0, 1.0);
  EXPECT_LT(e.place_m, 0.005);
  EXPECT_LT(e.height_m, 0.002);
  EXPECT_LT(e.pitch_rad, 0.015);
  EXPECT_LT(e.speed_m_s, 0.02);
}

TEST(SkateModel, RollsDownTheRampLikeThePlant) {
  // Slowest on the brow, where a hundredth of a metre per second is 20 mm at the foot of the ramp.
  // Without the bend within a step (kernel/contact.h): 78 mm, 17 mm, 112 mrad.
  const Errors e = errors_on("ramp", -0.1, 1.2);
  EXPECT_LT(e.place_m, 0.055);
  EXPECT_LT(e.height_m, 0.012);
  EXPECT_LT(e.pitch_rad, 0.08);
  EXPECT_LT(e.speed_m_s, 0.13);
}

}  // namespace
}  // namespace sanso
