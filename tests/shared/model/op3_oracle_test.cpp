// The specialised OP3 dynamics against two other derivations: the generic tree, and MuJoCo on the
// same figures.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "shared/model/ground.h"
#include "shared/model/op3_kinematics.h"
#include "shared/model/op3_step.h"
#include "tests/oracle/op3_momentum.h"
#include "tests/oracle/op3_tree.h"
#include "tests/shared/model/op3_states.h"
#include "tests/support/mjcf_of_tree.h"
#include "tests/support/mujoco_model.h"

namespace sanso::model {
namespace {

constexpr unsigned kSeed = 20261121;
constexpr int kStates = 1000;
constexpr double kStep = 0.06;
using Velocity = Eigen::Matrix<double, kNv, 1>;

// Servos without stiffness, damping and rotor: the step's velocity change is then h times the free
// acceleration at its middle, exactly.
ModelParameters limp_parameters() {
  ModelParameters theta = nominal_parameters();
  for (auto& servo : theta.servo)
    servo = {.stiffness = 0, .damping = 0, .armature = 0, .coulomb = 0, .torque_limit = 4.1};
  return theta;
}

Velocity free_acceleration(const StepModel& model, const State& x) {
  StepScratch scratch;
  State next;
  const Input u = joints(x);
  analytical_step(model, make_plane(), x.data(), u.data(), kStep, 1, next.data(), scratch);
  return (next - x).segment<kNv>(kXVel) / kStep;
}

template <class A, class B>
void expect_close(const A& ours, const B& theirs, const char* what, int sample) {
  const double scale = std::max(1.0, theirs.cwiseAbs().maxCoeff());
  ASSERT_LE((ours - theirs).cwiseAbs().maxCoeff(), 1e-9 * scale)
      << what << ", sample " << sample << ", seed " << kSeed;
}

TEST(Op3Oracle, FreeAccelerationAgreesWithTreeAndMujoco) {
  std::mt19937 rng(kSeed);
  const StepModel model = make_step_model(limp_parameters());
  const Tree tree = op3_tree(limp_parameters());
  testing::Mujoco mj(testing::mjcf_of(tree));
  ASSERT_EQ(mj.model->nv, kNv);
  TreeScratch scratch;
  TreeVector dv;
  for (int k = 0; k < kStates; ++k) {
    const State x = state_in_the_air(rng);
    const Velocity ours = free_acceleration(model, x);
    const State middle = drifted(x, 0.5 * kStep);
    ASSERT_EQ(forward_dynamics(tree, middle.head<kNq>(), middle.tail<kNv>(), TreeVector::Zero(kNv),
                               scratch, dv),
              Status::ok);
    expect_close(ours, dv, "tree", k);
    std::copy_n(middle.data(), kNq, mj.data->qpos);
    std::copy_n(middle.data() + kNq, kNv, mj.data->qvel);
    mj_forward(mj.model.get(), mj.data.get());
    expect_close(ours, Eigen::Map<Velocity>(mj.data->qacc), "MuJoCo", k);
  }
}

// World direction of a contact axis (forward, across, normal) of a foot on level ground.
Mat3 contact_axes(const Kinematics& kin, int foot) {
  const Vec3 normal = Vec3::UnitZ();
  Vec3 across = normal.cross(kin.R_world_link[foot_body(foot)].col(0));
  across.normalize();
  Mat3 axes;
  axes << across.cross(normal), across, normal;
  return axes;
}

// The step's own equation at its middle q = q0 + h/2 v, every term from other code:
// (M + armature + h/2 D + h^2/4 K) dv = h (K (u - q) - D v - bias) + sum J' lambda,
// q' = q + h/2 (v + dv)
TEST(Op3Oracle, StepObeysItsEquationWithContact) {
  std::mt19937 rng(kSeed + 1);
  const ModelParameters theta = nominal_parameters();
  const StepModel model = make_step_model(theta);
  const Tree tree = op3_tree(theta);  // armature on the diagonal
  TreeScratch tree_scratch;
  TreeMatrix M;
  TreeVector bias;
  StepScratch scratch;
  int with_contact = 0;
  for (int k = 0; k < 300; ++k) {
    const State x = state_near_standing(rng);
    const Input u = random_input(rng, x);
    State next;
    analytical_step(model, make_plane(), x.data(), u.data(), kStep, 1, next.data(), scratch);
    const Velocity dv = (next - x).segment<kNv>(kXVel);
    const State middle = drifted(x, 0.5 * kStep);
    State end = middle;
    end.tail<kNv>() += dv;
    expect_close(next, drifted(end, 0.5 * kStep), "way", k);

    crba(tree, middle.head<kNq>(), tree_scratch, M);
    rnea(tree, middle.head<kNq>(), x.tail<kNv>(), TreeVector::Zero(kNv), tree_scratch, bias);
    Velocity right = -kStep * bias;
    for (int j = 0; j < kNumJoints; ++j) {
      const ServoParameters& servo = theta.servo[j];
      const double error = u[j] - middle[kXJoint + j];
      // full duty: secant
      const double stiffness = std::min(servo.stiffness, servo.torque_limit / std::abs(error));
      M(6 + j, 6 + j) += 0.5 * kStep * servo.damping + 0.25 * kStep * kStep * stiffness;
      right[6 + j] += kStep * (stiffness * error - servo.damping * x[kXJointRate + j]);
    }
    Kinematics kin;
    forward_kinematics(middle, kin);
    for (int f = 0; f < kNumFeet; ++f)
      for (int c = 0; c < kCornersPerFoot; ++c) {
        const Vec3 lambda(scratch.lambda[f][c]);
        const Vec3 p = point_in_world(kin, foot_body(f), sole_corner_in_foot(f, c));
        right += point_jacobian(kin, foot_body(f), p).transpose() * (contact_axes(kin, f) * lambda);
        with_contact += lambda[2] > 0;
        ASSERT_NEAR(scratch.gap[f][c], p[2], 1e-12) << "gap of foot " << f << " corner " << c;
      }
    const Velocity expected = Eigen::LLT<TreeMatrix>(M).solve(right);
    expect_close(dv, expected, "velocity change", k);
  }
  EXPECT_GT(with_contact, 500) << "the sample must touch the ground";
}

TEST(Op3Oracle, KinematicsAgreeWithTree) {
  std::mt19937 rng(kSeed + 2);
  const Tree tree = op3_tree(nominal_parameters());
  const StepModel model = make_step_model(limp_parameters());
  const Tree limp = op3_tree(limp_parameters());
  TreeScratch scratch;
  TreeJacobian linear, angular;
  for (int k = 0; k < 100; ++k) {
    const State x = state_in_the_air(rng);
    Kinematics kin;
    forward_kinematics(x, kin);
    forward_kinematics(tree, x.head<kNq>(), scratch.kin);
    for (int i = 0; i < kNumBodies; ++i) {
      expect_close(kin.R_world_link[i], scratch.kin.R_world_link[i], "rotation", i);
      expect_close(kin.p_world_link[i], scratch.kin.p_world_link[i], "position", i);
    }
    for (const int foot : {kRightFoot, kLeftFoot}) {
      const int body = foot_body(foot);
      const Vec3 corner = sole_corner_in_foot(foot, 1);
      point_jacobian(tree, scratch.kin, body - 1, corner, linear, angular);
      expect_close(point_jacobian(kin, body, point_in_world(kin, body, corner)), linear,
                   "linear Jacobian", k);
      expect_close(rotation_jacobian(kin, body), angular, "angular Jacobian", k);
    }
    const TreeEnergy e = energy(limp, x.head<kNq>(), x.tail<kNv>(), scratch);
    EXPECT_NEAR(energy(model, kin, x), e.kinetic + e.potential,
                1e-9 * (e.kinetic + std::abs(e.potential)));
    crba(limp, x.head<kNq>(), scratch, scratch.M);
    // rows of the base force are the momentum
    const Vec3 linear_momentum = scratch.M.topRows<3>() * x.tail<kNv>();
    expect_close(momentum(model, kin, x).linear, linear_momentum, "momentum", k);
  }
}

// How far one step in the air is from "gravity alone changes the momentum".
double momentum_defect(const StepModel& model, const State& x, const Input& u, double h) {
  StepScratch scratch;
  State next;
  analytical_step(model, make_plane(), x.data(), u.data(), h, 1, next.data(), scratch);
  Kinematics before, after;
  forward_kinematics(x, before);
  forward_kinematics(next, after);
  const Momentum a = momentum(model, before, x), b = momentum(model, after, next);
  const Vec3 gravity_impulse = h * model.body[0].subtree_mass * Vec3(0, 0, -9.81);
  return (b.angular - a.angular).norm() + (b.linear - a.linear - gravity_impulse).norm();
}

TEST(Op3Law, ServosCannotChangeTheMomentum) {
  // internal forces, however stiff, neither move the centre of mass nor spin the robot; a
  // first-order step breaks this by h^2 only, so halving h must quarter the defect
  std::mt19937 rng(kSeed + 3);
  ModelParameters theta = nominal_parameters();
  // a rotor's own momentum is not that of its link
  for (auto& servo : theta.servo) servo.armature = 0.0;
  const StepModel model = make_step_model(theta);
  for (int k = 0; k < 100; ++k) {
    const State x = state_in_the_air(rng);
    const Input u = random_input(rng, x);
    EXPECT_NEAR(momentum_defect(model, x, u, 1e-6) / momentum_defect(model, x, u, 2e-6), 0.25, 0.02)
        << "sample " << k;
  }
}

}  // namespace
}  // namespace sanso::model
