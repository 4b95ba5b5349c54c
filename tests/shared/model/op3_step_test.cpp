// Laws of the one-step model: standing, falling, symmetry, contact, and lanes against the scalar
// code.
#include "shared/model/op3_step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "shared/model/op3_kinematics.h"
#include "shared/model/step_batch.h"
#include "tests/oracle/op3_momentum.h"
#include "tests/shared/model/op3_states.h"

namespace sanso::model {
namespace {

constexpr double kStep = 0.06;
constexpr unsigned kSeed = 20240611;

State step(const StepModel& model, const Ground& ground, const State& x, const Input& u,
           StepScratch& scratch, double h = kStep, int substeps = 1) {
  State next;
  analytical_step(model, ground, x.data(), u.data(), h, substeps, next.data(), scratch);
  return next;
}

class Op3Step : public ::testing::Test {
 protected:
  StepModel model = make_step_model(nominal_parameters());
  Ground ground = make_plane();
  StepScratch scratch;
  std::mt19937 rng{kSeed};
};

TEST_F(Op3Step, StandingRobotStays) {
  State x = standing_state();
  const Input u = joints(x);
  scratch.warm_start = true;
  for (int k = 0; k < 100; ++k) x = step(model, ground, x, u, scratch);
  const Tangent d = minus(x, standing_state());
  EXPECT_LT(d.segment<3>(kDPos).norm(), 0.03) << "sag of the P controlled legs";
  EXPECT_LT(d.segment<3>(kDTheta).norm(), 0.2);
  EXPECT_LT(d.segment<kNv>(kDVel).norm(), 1e-3) << "at rest after 6 s";
}

TEST_F(Op3Step, DroppedRobotComesToRest) {
  State x = standing_state();
  x[kXPos + 2] += 0.05;
  const Input u = joints(x);
  scratch.warm_start = true;
  for (int k = 0; k < 150; ++k) x = step(model, ground, x, u, scratch);
  EXPECT_LT(x.segment<kNv>(kXVel).norm(), 1e-3);
  EXPECT_NEAR(x[kXPos + 2], standing_state()[kXPos + 2], 0.02);
}

TEST_F(Op3Step, SymmetricPoseGivesSymmetricForces) {
  // the lumped upper body is not quite symmetric (arms differ by tenths of a degree): make it so
  ModelParameters theta = nominal_parameters();
  theta.body[0].com[1] = theta.body[0].inertia[1] = theta.body[0].inertia[4] = 0.0;
  model = make_step_model(theta);
  const State x = standing_state();
  step(model, ground, x, joints(x), scratch);
  for (int k = 0; k < kCornersPerFoot; ++k) {
    EXPECT_NEAR(scratch.lambda[0][k][2], scratch.lambda[1][k][2], 1e-6) << "corner " << k;
    EXPECT_NEAR(scratch.lambda[0][k][0], scratch.lambda[1][k][0], 1e-6) << "corner " << k;
    EXPECT_NEAR(scratch.lambda[0][k][1], -scratch.lambda[1][k][1], 1e-6) << "corner " << k;
  }
}

TEST_F(Op3Step, ZerosOfJointsShiftWhatTheyReportAndAreTold) {
  ModelParameters theta = nominal_parameters();
  Tangent zeros = Tangent::Zero();
  std::normal_distribution<double> normal;
  for (int j = 0; j < kNumJoints; ++j)
    theta.servo[j].zero = zeros[kDJoint + j] = 0.03 * normal(rng);
  const StepModel put_together = make_step_model(theta);
  for (int draw = 0; draw < 50; ++draw) {
    const State x = state_near_standing(rng);
    const Input u = random_input(rng, x);
    const State reported =
        step(put_together, ground, plus(x, zeros), u + zeros.segment<kNumJoints>(kDJoint), scratch);
    EXPECT_LT(minus(reported, plus(step(model, ground, x, u, scratch), zeros)).norm(), 1e-9)
        << "seed " << kSeed << " draw " << draw;
  }
}

TEST_F(Op3Step, OnAGroundThatIsHigherAllIsHigher) {
  ModelParameters theta = nominal_parameters();
  theta.ground_height = 0.004;
  Tangent up = Tangent::Zero();
  up[kDPos + 2] = theta.ground_height;
  const StepModel higher = make_step_model(theta);
  for (int draw = 0; draw < 50; ++draw) {
    const State x = state_near_standing(rng);
    const Input u = random_input(rng, x);
    const State there = step(higher, ground, plus(x, up), u, scratch);
    EXPECT_LT(minus(there, plus(step(model, ground, x, u, scratch), up)).norm(), 1e-9)
        << "seed " << kSeed << " draw " << draw;
  }
}

TEST_F(Op3Step, FreeFallIsExact) {
  State x = standing_state();
  x[kXPos + 2] = 3.0;
  x[kXVel] = 1.0;
  const State next = step(model, ground, x, joints(x), scratch);
  Kinematics before, after;
  forward_kinematics(x, before);
  forward_kinematics(next, after);
  const Vec3 p = momentum(model, after, next).linear - momentum(model, before, x).linear;
  const double mass = model.body[0].subtree_mass;
  EXPECT_NEAR(p[2], -9.81 * kStep * mass, 1e-9);
  EXPECT_NEAR(p.head<2>().norm(), 0.0, 1e-9);
  EXPECT_NEAR(next[kXPos + 2], 3.0 - 0.5 * 9.81 * kStep * kStep, 1e-9);
  EXPECT_NEAR(next[kXPos] - x[kXPos], kStep, 1e-9);
}

TEST_F(Op3Step, ContactLawHolds) {
  const double eps = model.contact.regularization;
  for (int trial = 0; trial < 200; ++trial) {
    const State x = state_near_standing(rng);
    step(model, ground, x, random_input(rng, x), scratch);
    double dissipated = 0.0;
    for (int f = 0; f < kNumFeet; ++f)
      for (int k = 0; k < kCornersPerFoot; ++k) {
        const double* l = scratch.lambda[f][k];
        const double* v = scratch.corner_velocity[f][k];
        ASSERT_GE(l[2], 0.0);
        ASSERT_LE(std::abs(l[0]), model.friction_forward * l[2] + 1e-12);
        ASSERT_LE(std::abs(l[1]), model.friction_sideways * l[2] + 1e-12);
        const double gap = scratch.gap[f][k], target = (gap > 0 ? gap : 0.3 * gap) * 2 / kStep;
        // the regularisation gives way by eps x diagonal x lambda: diagonal is under 20 1/kg for
        // this robot
        const double give = eps * 20.0 * l[2] + 1e-6;
        ASSERT_GE(v[2] + target, -give) << "seed " << kSeed << " trial " << trial;
        ASSERT_NEAR(l[2] * (v[2] + target), 0.0, l[2] * give) << "complementarity, trial " << trial;
        if (gap >= 0) dissipated += l[0] * v[0] + l[1] * v[1] + l[2] * v[2];
      }
    ASSERT_LE(dissipated, 1e-9) << "contact gives no energy, trial " << trial;
  }
}

TEST_F(Op3Step, ContactIsSolvedInEveryState) {
  StepModel patient = model;  // Gauss-Seidel alone, run until it stands still
  patient.contact.sweeps = 20000;
  patient.contact.rounds = 1;
  double worst = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const State x = state_near_standing(rng);
    const Input u = random_input(rng, x);
    const State expected = step(patient, ground, x, u, scratch);
    worst =
        std::max(worst, (step(model, ground, x, u, scratch) - expected).lpNorm<Eigen::Infinity>());
  }
  EXPECT_LT(worst, 1e-7) << "m/s, rad/s; seed " << kSeed;
}

/// Steps `Count` drawn states in lanes and one by one, on every instruction set; `step_lanes(x, u,
/// next, contact)`.
template <int Count, class StepLanes>
void expect_lanes_equal_scalar(const StepModel& model, const Ground& ground, std::mt19937& rng,
                               const StepLanes& step_lanes) {
  StepScratch scratch;
  for (const char* isa : {"portable", "avx2", "avx512"}) {
    if (!select_batch_isa(isa)) continue;
    for (int trial = 0; trial < 50; ++trial) {
      StatesOf<Count> x, next;
      InputsOf<Count> u;
      ContactsOf<Count> contact;
      State xs[Count];
      Input us[Count];
      for (int lane = 0; lane < Count; ++lane) {
        xs[lane] = state_near_standing(rng);
        us[lane] = random_input(rng, xs[lane]);
        for (int i = 0; i < kNx; ++i) x.v[i][lane] = xs[lane][i];
        for (int i = 0; i < kNu; ++i) u.v[i][lane] = us[lane][i];
      }
      step_lanes(x, u, next, contact);
      for (int lane = 0; lane < Count; ++lane) {
        const State expected = step(model, ground, xs[lane], us[lane], scratch);
        for (int i = 0; i < kNx; ++i)
          ASSERT_NEAR(next.v[i][lane], expected[i], 1e-9 * (1 + std::abs(expected[i])))
              << isa << " lane " << lane << " component " << i << " seed " << kSeed;
        for (int i = 0; i < kNumContactRows; ++i)
          ASSERT_NEAR(contact.v[i][lane], (&scratch.lambda[0][0][0])[i], 1e-8)
              << isa << " lane " << lane << " row " << i;
      }
    }
  }
}

TEST_F(Op3Step, EightLanesEqualScalar) {
  expect_lanes_equal_scalar<kLanes>(
      model, ground, rng, [&](const auto& x, const auto& u, auto& next, auto& contact) {
        step_batch(model, ground, &x, &u, {.h = kStep}, &next, &contact, 1);
      });
}

TEST_F(Op3Step, FourLanesEqualScalar) {
  expect_lanes_equal_scalar<kQuadLanes>(
      model, ground, rng, [&](const auto& x, const auto& u, auto& next, auto& contact) {
        step_quad(model, ground, x, u, {.h = kStep}, next, &contact);
      });
}

/// The steps for derivatives against whole steps: states a millionth away in random directions.
TEST_F(Op3Step, StepsNearbyAreRightToFirstOrder) {
  constexpr double eps = 1e-6;
  for (const char* isa : {"portable", "avx2", "avx512"}) {
    if (!select_batch_isa(isa)) continue;
    SCOPED_TRACE(isa);
    for (int trial = 0; trial < 40; ++trial) {
      SCOPED_TRACE(trial);
      const State x0 = state_near_standing(rng);
      const Input u0 = random_input(rng, x0);
      StateLanes x, next, held, neighbours;
      InputLanes u;
      ContactLanes contact;
      NominalStep nominal;
      State xs[kLanes];
      Input us[kLanes];
      // lane 0: the nominal point; even lanes: any direction; odd lanes: height, velocities and
      // inputs only, seen at the middle of the step
      for (int lane = 0; lane < kLanes; ++lane) {
        Tangent d = lane == 0 ? Tangent::Zero() : random_tangent(rng, eps, eps, eps, eps, eps, eps);
        if (lane % 2 == 1) d.head<2>().setZero(), d.segment<kNv - 3>(kDTheta).setZero();
        xs[lane] =
            lane % 2 == 0 ? plus(x0, d) : drifted(plus(drifted(x0, 0.5 * kStep), d), -0.5 * kStep);
        us[lane] = lane == 0 ? u0 : Input(u0 + eps / 0.15 * (random_input(rng, x0) - joints(x0)));
        for (int i = 0; i < kNx; ++i) x.v[i][lane] = x0[i];
        for (int i = 0; i < kNu; ++i) u.v[i][lane] = u0[i];
      }
      step_batch_keep(model, ground, x, u, {.h = kStep}, next, &contact, &nominal, 1);
      for (int lane = 0; lane < kLanes; ++lane) {
        for (int i = 0; i < kNx; ++i) x.v[i][lane] = xs[lane][i];
        for (int i = 0; i < kNu; ++i) u.v[i][lane] = us[lane][i];
      }
      step_held(model, ground, nominal, &x, &u, kStep, &held, 1);
      step_neighbours(model, nominal, &x, &u, kStep, &neighbours, 1);
      const State expected0 = step(model, ground, x0, u0, scratch);
      const auto change = [](const StateLanes& of, int lane) {
        State a, b;
        for (int i = 0; i < kNx; ++i) a[i] = of.v[i][lane], b[i] = of.v[i][0];
        return minus(a, b);
      };
      for (int lane = 1; lane < kLanes; ++lane) {
        const Tangent expected = minus(step(model, ground, xs[lane], us[lane], scratch), expected0);
        const double tolerance = 0.01 * expected.norm() + 1e-9;
        EXPECT_LT((change(held, lane) - expected).norm(), tolerance)
            << "any direction, lane " << lane;
        if (lane % 2 == 0) continue;
        EXPECT_LT((change(neighbours, lane) - expected).norm(), tolerance)
            << "same configuration at the middle, lane " << lane;
      }
    }
  }
}

TEST_F(Op3Step, AContactSolutionNearbyChangesNothing) {
  for (int trial = 0; trial < 100; ++trial) {
    const State x = state_near_standing(rng);
    const Input u = random_input(rng, x);
    const State expected = step(model, ground, x, u, scratch);
    StepScratch warm;
    step(model, ground, plus(x, random_tangent(rng, 1e-3, 1e-2, 1e-2, 0.03, 0.05, 0.1)), u, warm);
    warm.warm_start = true;
    EXPECT_LT((step(model, ground, x, u, warm) - expected).lpNorm<Eigen::Infinity>(), 1e-7)
        << "trial " << trial;
  }
}

}  // namespace
}  // namespace sanso::model
