// Inverse against forward kinematics, pendulum against ZMP: each pair is derived on its own.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/motion/make/balance.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/footsteps.h"
#include "host/motion/make/leg_ik.h"
#include "host/motion/make/retarget.h"

namespace sanso::motion {
namespace {

TEST(LegIk, ForwardKinematicsGivesTheFootBack) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  int reached = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    model::State x = model::neutral_state();
    x.head<3>() = math::Vec3(unit(random), unit(random), 0.25 + 0.01 * unit(random));
    x.segment<4>(model::kXQuat) =
        math::quat_exp({0.15 * unit(random), 0.15 * unit(random), 3 * unit(random)});
    const math::Mat3 R_world_base = math::rotation_matrix(model::base_quat(x));
    for (int side : {kRight, kLeft}) {
      const math::Vec3 p_base_foot(0.04 * unit(random),
                                   side_sign(side) * 0.035 + 0.03 * unit(random),
                                   -0.215 + 0.025 * unit(random));
      const math::Vec3 p_world_foot = model::base_position(x) + R_world_base * p_base_foot;
      const math::Mat3 R_base_foot = math::rotation_matrix(
          math::quat_exp({0.2 * unit(random), 0.2 * unit(random), 0.3 * unit(random)}));
      const math::Mat3 R_world_foot = R_world_base * R_base_foot;
      const LegSolution leg =
          solve_leg(side, model::base_position(x), R_world_base, p_world_foot, R_world_foot);
      if (leg.reach > 0.998) continue;
      ++reached;
      x.segment<6>(model::kXJoint + 6 * side) = leg.q;
      const BodyPoints points = body_points(x);
      // the roll axes miss the hip's centre by 0.1 mm (ROBOTIS' figures), which the analytic
      // solution leaves out
      EXPECT_LT((points.p_world_foot[side] - p_world_foot).norm(), 0.04e-3)
          << "trial " << trial << ", seed " << kSeed;
      EXPECT_LT((points.R_world_foot[side] - R_world_foot).norm(), 1e-9)
          << "trial " << trial << ", seed " << kSeed;
    }
  }
  EXPECT_GT(reached, 1500);
}

TEST(LegIk, KneesBendForwardOnBothLegs) {
  const math::Vec3 base(0, 0, 0.25);
  for (int side : {kRight, kLeft}) {
    const math::Vec3 foot(0, side_sign(side) * 0.035, 0.0305);
    const auto leg = solve_leg(side, base, math::Mat3::Identity(), foot, math::Mat3::Identity());
    EXPECT_GT(side_sign(side) * leg.q[3], 0.5);
  }
}

TEST(Footsteps, ASwingFootRisesBeforeItGoesForward) {
  StepPlan plan;
  plan.start = {Eigen::Vector2d(0.0, -0.05), Eigen::Vector2d(0.0, 0.05)};
  plan.swings = {{.side = 1, .lift_s = 1.0, .land_s = 2.0, .from = {0.0, 0.05}, .to = {0.1, 0.06}}};
  plan.swing_height_m = 0.03;
  plan.swing_sharpness = 2.0;
  plan.swing_dwell = 0.15;
  const double ground = plan.foot_at(1, 0.5).z();
  EXPECT_EQ(plan.foot_at(1, 1.15).x(), 0.0);
  EXPECT_NEAR(plan.foot_at(1, 1.15).z() - ground, 0.03 * std::pow(4 * 0.15 * 0.85, 2), 1e-12);
  EXPECT_GT(plan.foot_at(1, 1.16).x(), 0.0);
  EXPECT_NEAR(plan.foot_at(1, 1.5).x(), 0.05, 1e-12);
  EXPECT_NEAR(plan.foot_at(1, 1.5).z() - ground, 0.03, 1e-12);
  EXPECT_EQ(plan.foot_at(1, 1.86).x(), 0.1) << "straight down at the end, too";
  EXPECT_EQ(plan.foot_at(1, 2.5).z(), ground);
  EXPECT_EQ(plan.foot_at(0, 1.5).x(), 0.0) << "the other foot stands";
}

TEST(ComForZmp, IsTheInverseOfThePendulum) {
  std::vector<double> zmp;
  for (int k = 0; k < 600; ++k) zmp.push_back(k < 200 ? 0.0 : k < 400 ? 0.05 : 0.02);
  const double h = 0.24, dt = 0.01;
  const std::vector<double> c = com_for_zmp(zmp, h, dt);
  for (std::size_t k = 1; k + 1 < c.size(); ++k) {
    EXPECT_NEAR(c[k] - h / 9.81 * (c[k + 1] - 2 * c[k] + c[k - 1]) / (dt * dt), zmp[k], 1e-9);
  }
  EXPECT_DOUBLE_EQ(c.front(), 0.0);
  EXPECT_DOUBLE_EQ(c.back(), 0.02);
  EXPECT_GT(c[195], 0.015) << "the weight moves before the support does";
}

TEST(Zmp, OfStandingIsBelowTheCentreOfMass) {
  Trajectory still;
  model::State x = model::neutral_state();
  x[2] = 0.25;
  for (int j = 0; j < model::kNumJoints; ++j) x[model::kXJoint + j] = 0.03 * j;
  still.x.assign(5, x);
  const auto zmp = zmp_of(still);
  const math::Vec3 com = body_points(x).centre_of_mass();
  EXPECT_NEAR(zmp[2].x, com.x(), 1e-12);
  EXPECT_NEAR(zmp[2].y, com.y(), 1e-12);
  EXPECT_NEAR(zmp[2].load, 1.0, 1e-12);
}

TEST(Hull, DistanceIsPositiveInsideAndNegativeOutside) {
  const std::vector<Eigen::Vector2d> square = {{0, 0}, {1, 1}, {1, 0}, {0, 1}, {0.5, 0.5}};
  EXPECT_NEAR(distance_inside_hull({0.5, 0.25}, square), 0.25, 1e-12);
  EXPECT_NEAR(distance_inside_hull({0.5, -0.1}, square), -0.1, 1e-12);
}

TEST(SolveBody, PutsTheZmpWhereItIsWanted) {
  BodyTarget target;
  for (int k = 0; k < 500; ++k) {
    target.p_world_foot.push_back({math::Vec3(0, -0.035, 0.0305), math::Vec3(0, 0.035, 0.0305)});
    target.carries.push_back({true, true});
    target.base_height.push_back(0.262);
    target.ground.push_back({0.024, k < 150 || k > 350 ? 0.0 : 0.03});
  }
  const Retargeted solved = solve_body(target);
  const auto zmp = zmp_of(solved.trajectory);
  for (std::size_t k : {50u, 250u, 450u}) {
    EXPECT_NEAR(zmp[k].x, 0.024, 0.002) << k;
    EXPECT_NEAR(zmp[k].y, target.ground[k].y(), 0.002) << k;
  }
  EXPECT_LT(solved.trajectory.x.front().tail<model::kNv>().norm(), 0.01) << "starts at rest";
  EXPECT_LT(solved.trajectory.x.back().tail<model::kNv>().norm(), 0.01) << "ends at rest";
}

}  // namespace
}  // namespace sanso::motion
