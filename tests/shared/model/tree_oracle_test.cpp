// The generic tree against MuJoCo on the same figures: inertia, bias, accelerations, Jacobians; and
// its own laws.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "tests/oracle/tree.h"
#include "tests/support/mjcf_of_tree.h"
#include "tests/support/mujoco_model.h"

namespace sanso::model {
namespace {

constexpr std::uint64_t kSeed = 20261121;
constexpr int kStates = 1000;
// Both sides work in double precision on matrices of condition 1e4 at most; 1e-9 leaves room for
// the order of sums only.
constexpr double kRelative = 1e-9;

class Random {
 public:
  explicit Random(std::uint64_t seed) : rng_(seed) {}
  double uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(rng_);
  }
  Vec3 vector(double limit) {
    return {uniform(-limit, limit), uniform(-limit, limit), uniform(-limit, limit)};
  }
  Mat3 rotation() { return math::rotation_matrix(math::quat_exp(vector(1.8))); }
  LinkInertia link() {
    // obeys the triangle inequality
    const Vec3 d(uniform(1e-3, 2e-3), uniform(1e-3, 2e-3), uniform(1e-3, 2e-3));
    const Mat3 R = rotation();
    return {uniform(0.05, 1.5), vector(0.1), R * d.asDiagonal() * R.transpose()};
  }

 private:
  std::mt19937_64 rng_;
};

TreeJoint hinge(int parent, const Vec3& p, const Vec3& axis, const LinkInertia& link) {
  TreeJoint j;
  j.parent = parent;
  j.p_parent_link0 = p;
  j.axis = axis;
  j.link = link;
  return j;
}

Tree pendulum() {
  Tree t;
  t.joints.try_push(hinge(-1, {0, 0, 1}, Vec3::UnitY(),
                          {0.4, {0, 0, -0.15}, Vec3(2e-3, 2e-3, 1e-4).asDiagonal()}));
  return t;
}

Tree two_link_arm() {
  Tree t = pendulum();
  t.joints[0].armature = 0.01;
  t.joints.try_push(hinge(0, {0, 0, -0.3}, Vec3::UnitY(),
                          {0.2, {0.01, 0.02, -0.1}, Vec3(1e-3, 1e-3, 1e-4).asDiagonal()}));
  return t;
}

// Depth-first chains of random joints, axes, rotations and bodies: two legs and an arm on a base.
Tree random_tree(Random& random, bool floating) {
  Tree t;
  t.floating = floating;
  if (floating) t.base = random.link();
  for (const int length : {6, 6, 3}) {
    int parent = -1;
    for (int i = 0; i < length; ++i) {
      TreeJoint j =
          hinge(parent, random.vector(0.2), random.vector(1.0).normalized(), random.link());
      j.R_parent_link0 = random.rotation();
      j.kind = i == 4 ? JointKind::prismatic : JointKind::revolute;
      j.armature = random.uniform(0, 0.05);
      parent = t.num_joints();
      t.joints.try_push(j);
    }
  }
  return t;
}

struct Sample {
  TreeVector q, v, dv, tau;
};

Sample random_sample(const Tree& tree, Random& random) {
  Sample s;
  s.q.setZero(tree.nq());
  for (TreeVector* x : {&s.v, &s.dv, &s.tau}) x->setZero(tree.nv());
  for (double& x : s.q) x = random.uniform(-2, 2);
  for (double& x : s.v) x = random.uniform(-5, 5);
  for (double& x : s.dv) x = random.uniform(-20, 20);
  for (double& x : s.tau) x = random.uniform(-3, 3);
  if (tree.floating) s.q.segment<4>(3) = math::quat_exp(random.vector(1.8));
  return s;
}

template <class A, class B>
void expect_close(const A& ours, const B& theirs, const char* what, int sample) {
  const double scale = std::max(1.0, theirs.cwiseAbs().maxCoeff());
  ASSERT_LE((ours - theirs).cwiseAbs().maxCoeff(), kRelative * scale)
      << what << ", sample " << sample << ", seed " << kSeed;
}

void expect_agrees_with_mujoco(const Tree& tree, Random& random) {
  testing::Mujoco mj(testing::mjcf_of(tree));
  ASSERT_EQ(mj.model->nv, tree.nv());
  TreeScratch scratch;
  TreeMatrix M;
  TreeVector bias, dv;
  TreeJacobian linear, angular;
  const int last = tree.num_joints() - 1;
  const int body = mj_name2id(mj.model.get(), mjOBJ_BODY, ("link" + std::to_string(last)).c_str());
  for (int k = 0; k < kStates; ++k) {
    const Sample s = random_sample(tree, random);
    const int nv = tree.nv();
    Eigen::Map<Eigen::VectorXd>(mj.data->qpos, tree.nq()) = s.q;
    Eigen::Map<Eigen::VectorXd>(mj.data->qvel, nv) = s.v;
    Eigen::Map<Eigen::VectorXd>(mj.data->qfrc_applied, nv) = s.tau;
    mj_forward(mj.model.get(), mj.data.get());

    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> M_mujoco(nv, nv);
    mj_fullM(mj.model.get(), M_mujoco.data(), mj.data->qM);
    crba(tree, s.q, scratch, M);
    expect_close(M, M_mujoco, "inertia", k);

    rnea(tree, s.q, s.v, TreeVector::Zero(nv), scratch, bias);
    expect_close(bias, Eigen::Map<Eigen::VectorXd>(mj.data->qfrc_bias, nv), "bias", k);

    ASSERT_EQ(forward_dynamics(tree, s.q, s.v, s.tau, scratch, dv), Status::ok);
    expect_close(dv, Eigen::Map<Eigen::VectorXd>(mj.data->qacc, nv), "acceleration", k);

    const Vec3 p_link_point = random.vector(0.1);
    forward_kinematics(tree, s.q, scratch.kin);
    const Vec3 p_world =
        scratch.kin.p_world_link[last + 1] + scratch.kin.R_world_link[last + 1] * p_link_point;
    point_jacobian(tree, scratch.kin, last, p_link_point, linear, angular);
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> jacp(3, nv), jacr(3, nv);
    mj_jac(mj.model.get(), mj.data.get(), jacp.data(), jacr.data(), p_world.data(), body);
    expect_close(linear, jacp, "linear Jacobian", k);
    expect_close(angular, jacr, "angular Jacobian", k);
  }
}

TEST(TreeOracle, PendulumAgreesWithMujoco) {
  Random random(kSeed);
  expect_agrees_with_mujoco(pendulum(), random);
}

TEST(TreeOracle, TwoLinkArmAgreesWithMujoco) {
  Random random(kSeed);
  expect_agrees_with_mujoco(two_link_arm(), random);
}

TEST(TreeOracle, RandomFloatingTreeAgreesWithMujoco) {
  Random random(kSeed);
  const Tree tree = random_tree(random, true);
  expect_agrees_with_mujoco(tree, random);
}

TEST(TreeOracle, RandomFixedTreeAgreesWithMujoco) {
  Random random(kSeed + 1);
  const Tree tree = random_tree(random, false);
  expect_agrees_with_mujoco(tree, random);
}

TEST(TreeLaw, InverseDynamicsInvertsForwardDynamics) {
  Random random(kSeed + 2);
  const Tree tree = random_tree(random, true);
  TreeScratch scratch;
  TreeVector dv, tau;
  for (int k = 0; k < kStates; ++k) {
    const Sample s = random_sample(tree, random);
    ASSERT_EQ(forward_dynamics(tree, s.q, s.v, s.tau, scratch, dv), Status::ok);
    rnea(tree, s.q, s.v, dv, scratch, tau);
    expect_close(tau, s.tau, "torque", k);
  }
}

TEST(TreeLaw, PowerOfForcesIsRateOfEnergy) {
  // d/dt (kinetic + potential) = tau . v: central difference along the true motion, second order in
  // the step.
  Random random(kSeed + 3);
  const Tree tree = random_tree(random, true);
  TreeScratch scratch;
  TreeVector dv;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 100; ++k) {
    const Sample s = random_sample(tree, random);
    ASSERT_EQ(forward_dynamics(tree, s.q, s.v, s.tau, scratch, dv), Status::ok);
    const auto total_at = [&](double t) {
      // second-order path: constant acceleration; its error in q is O(t^3)
      const TreeVector q = integrate(tree, s.q, TreeVector(s.v + 0.5 * t * dv), t);
      const TreeEnergy e = energy(tree, q, TreeVector(s.v + t * dv), scratch);
      return e.kinetic + e.potential;
    };
    const double rate = (total_at(kStep) - total_at(-kStep)) / (2 * kStep), power = s.tau.dot(s.v);
    EXPECT_NEAR(rate, power, 1e-4 * std::max(100.0, std::abs(power))) << "sample " << k;
  }
}

TEST(TreeLaw, JacobianIsDerivativeOfPosition) {
  Random random(kSeed + 4);
  const Tree tree = random_tree(random, true);
  TreeKinematics kin;
  TreeJacobian linear, angular;
  const int link = 11;
  for (int k = 0; k < 20; ++k) {
    const Sample s = random_sample(tree, random);
    const Vec3 point = random.vector(0.1);
    forward_kinematics(tree, s.q, kin);
    point_jacobian(tree, kin, link, point, linear, angular);
    for (int i = 0; i < tree.nv(); ++i) {
      const auto position_at = [&](double h) {
        forward_kinematics(
            tree, integrate(tree, s.q, TreeVector(TreeVector::Unit(tree.nv(), i)), h), kin);
        return Vec3(kin.p_world_link[link + 1] + kin.R_world_link[link + 1] * point);
      };
      const Vec3 difference = (position_at(1e-6) - position_at(-1e-6)) / 2e-6;
      EXPECT_LE((difference - linear.col(i)).norm(), 1e-8) << "column " << i;
    }
  }
}

TEST(TreeLaw, InertiaIsPositiveDefinite) {
  Random random(kSeed + 5);
  const Tree tree = random_tree(random, true);
  TreeScratch scratch;
  TreeMatrix M;
  for (int k = 0; k < 100; ++k) {
    crba(tree, random_sample(tree, random).q, scratch, M);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(M).eigenvalues()[0], 0.0);
  }
}

TEST(TreeLaw, MasslessLinkIsRefused) {
  Tree tree = pendulum();
  tree.joints[0].link = LinkInertia{};
  TreeScratch scratch;
  TreeVector dv;
  EXPECT_EQ(forward_dynamics(tree, TreeVector::Zero(1), TreeVector::Zero(1), TreeVector::Zero(1),
                             scratch, dv),
            Status::not_ready);
}

}  // namespace
}  // namespace sanso::model
