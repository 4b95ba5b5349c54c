// Laws of the one-step model on skates: how it coasts, what holds it across, how it follows a bend,
// and its differences.
#include <gtest/gtest.h>

#include <cmath>

#include "shared/model/ground.h"
#include "shared/model/op3_step.h"
#include "shared/model/step_batch.h"
#include "tests/oracle/op3_momentum.h"
#include "tests/shared/model/op3_states.h"

namespace sanso::model {
namespace {

constexpr double kStep = 0.06;

State standing_on_skates() {
  State x = standing_state();
  x[kXPos + 2] += 2 * kWheelRadius;
  return x;
}

/// Level, then 12 deg downhill, then level again, with the bends of shared/grounds/ramp.toml.
Ground ramp() {
  const GroundCorner corners[] = {
      {-1.0, 0.0, 0.0}, {0.234, 0.0, 0.8}, {0.704463, -0.1, 1.0}, {4.0, -0.1, 0.0}};
  Ground g;
  EXPECT_EQ(make_profile(corners, 4, g).what, nullptr);
  return g;
}

class SkateStep : public ::testing::Test {
 protected:
  State step(const State& x, const Input& u, const Ground& ground) {
    State next;
    analytical_step(model, ground, x.data(), u.data(), kStep, 1, next.data(), scratch);
    return next;
  }
  StepModel model = make_step_model(skating_parameters());
  StepScratch scratch;
};

TEST_F(SkateStep, WeighsFiftyGramsAFootMore) {
  const StepModel without = make_step_model(nominal_parameters());
  EXPECT_NEAR(model.body[0].subtree_mass - without.body[0].subtree_mass, 0.1, 1e-12);
  Kinematics kin;
  const State x = standing_on_skates();
  forward_kinematics(x, kin);
  const Vec3 shift = centre_of_mass(model, kin) * model.body[0].subtree_mass -
                     centre_of_mass(without, kin) * without.body[0].subtree_mass;
  // standing straight on both: the skates' mass is half above the wheels' axles
  EXPECT_NEAR(shift[2] / 0.1, 1.25 * kWheelRadius, 1e-3);
  EXPECT_NEAR(shift[1], 0.0, 1e-9);
}

TEST_F(SkateStep, StandsWhereItIsPut) {
  const State start = standing_on_skates();
  State x = start;
  scratch.warm_start = true;
  for (int k = 0; k < 50; ++k) x = step(x, joints(start), make_plane());
  EXPECT_NEAR(x[kXPos + 2], start[kXPos + 2], 0.01);
  EXPECT_LT(x.segment<kNv>(kXVel).norm(), 0.02);
}

TEST_F(SkateStep, LosesSpeedByItsRollingFriction) {
  State x = standing_on_skates();
  const Input u = joints(x);
  scratch.warm_start = true;
  for (int k = 0; k < 30; ++k) x = step(x, u, make_plane());
  x[kXVel] = 1.0;
  for (int k = 0; k < 5; ++k) x = step(x, u, make_plane());  // legs give way a little
  Kinematics kin;
  forward_kinematics(x, kin);
  const double before = momentum(model, kin, x).linear[0];
  for (int k = 0; k < 20; ++k) x = step(x, u, make_plane());
  forward_kinematics(x, kin);
  const double slowed = (before - momentum(model, kin, x).linear[0]) / model.body[0].subtree_mass;
  EXPECT_NEAR(slowed, 0.02 * 9.81 * 20 * kStep, 0.02 * slowed);
}

TEST_F(SkateStep, DoesNotSlipAcross) {
  State x = standing_on_skates();
  const Input u = joints(x);
  scratch.warm_start = true;
  for (int k = 0; k < 30; ++k) x = step(x, u, make_plane());
  const double y = x[kXPos + 1];
  x[kXVel] = 0.5, x[kXVel + 1] = 0.05;
  for (int k = 0; k < 20; ++k) x = step(x, u, make_plane());
  EXPECT_NEAR(x[kXPos + 1], y, 0.015);
  EXPECT_NEAR(x[kXVel + 1], 0.0, 0.02);
  EXPECT_GT(x[kXPos], 0.4);
}

TEST_F(SkateStep, WheelsStayOnTheRampThroughItsBends) {
  State x = standing_on_skates();
  const Input u = joints(x);
  const Ground ground = ramp();
  scratch.warm_start = true;
  x[kXVel] = 0.6;
  double deepest = 0.0, highest = 0.0, fastest = 0.0;
  while (x[kXPos] < 1.3) {
    x = step(x, u, ground);
    ASSERT_TRUE(x.allFinite());
    Kinematics kin;
    forward_kinematics(x, kin);
    for (const int foot : {kRightFoot, kLeftFoot})
      for (const double end : {-1.0, 1.0}) {
        const Vec3 wheel = point_in_world(
            kin, foot_body(foot), {kSoleCentreX + end * kSkates.half_length, 0.0, kSkates.height});
        const double gap = wheel[2] - ground_height(ground, wheel[0]);
        deepest = std::min(deepest, gap);
        highest = std::max(highest, gap);
      }
    fastest = std::max(fastest, x[kXVel]);
  }
  // 78 mm of way in a step: a bend of 1 m leaves its tangent by 3 mm in it
  EXPECT_GT(deepest, -0.003);
  EXPECT_LT(highest, 0.002);
  const double slope = 12 * M_PI / 180;
  const double at_end = std::sqrt(0.36 + 2 * 9.81 * 0.1 * (1 - 0.02 / std::tan(slope)));
  EXPECT_NEAR(fastest, at_end, 0.06 * at_end);
}

TEST_F(SkateStep, NeighboursAndHeldStepsAreItsDifferences) {
  const Ground ground = ramp();
  std::mt19937 rng(7);
  constexpr double eps = 1e-6;
  State x0 = standing_on_skates();
  x0[kXPos] = -0.2, x0[kXVel] = 0.8;
  const Input u0 = joints(x0);
  for (int k = 0; k < 3; ++k) x0 = step(x0, u0, ground);  // off the edge between touching and not
  for (int k = 0; x0[kXPos] < 1.2; ++k) {
    SCOPED_TRACE(k);
    StateLanes x, next, held, neighbours;
    InputLanes u;
    ContactLanes contact;
    NominalStep nominal;
    State xs[kLanes];
    // lane 0: the nominal point; even lanes: any direction; odd ones: height and velocities only,
    // seen at the middle of the step
    for (int lane = 0; lane < kLanes; ++lane) {
      Tangent d = lane == 0 ? Tangent::Zero() : random_tangent(rng, eps, eps, eps, eps, eps, eps);
      if (lane % 2 == 1) d.head<2>().setZero(), d.segment<kNv - 3>(kDTheta).setZero();
      xs[lane] =
          lane % 2 == 0 ? plus(x0, d) : drifted(plus(drifted(x0, 0.5 * kStep), d), -0.5 * kStep);
      for (int i = 0; i < kNx; ++i) x.v[i][lane] = x0[i];
      for (int i = 0; i < kNu; ++i) u.v[i][lane] = u0[i];
    }
    step_batch_keep(model, ground, x, u, {.h = kStep}, next, &contact, &nominal, 1);
    for (int lane = 0; lane < kLanes; ++lane)
      for (int i = 0; i < kNx; ++i) x.v[i][lane] = xs[lane][i];
    step_held(model, ground, nominal, &x, &u, kStep, &held, 1);
    step_neighbours(model, nominal, &x, &u, kStep, &neighbours, 1);
    const State expected0 = step(x0, u0, ground);
    const auto change = [](const StateLanes& of, int lane) {
      State a, b;
      for (int i = 0; i < kNx; ++i) a[i] = of.v[i][lane], b[i] = of.v[i][0];
      return minus(a, b);
    };
    for (int lane = 1; lane < kLanes; ++lane) {
      const Tangent expected = minus(step(xs[lane], u0, ground), expected0);
      EXPECT_LT((change(held, lane) - expected).norm(), 0.01 * expected.norm() + 1e-9) << lane;
      if (lane % 2 == 0) continue;
      // holds the normal, which turns a little with the way rolled: that of it is neglected which
      // the change of velocity within the step sees
      EXPECT_LT((change(neighbours, lane) - expected).norm(), 0.08 * expected.norm() + 1e-9)
          << lane;
    }
    x0 = expected0;
  }
}

}  // namespace
}  // namespace sanso::model
