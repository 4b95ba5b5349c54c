// Equations of motion: what must hold of any tree, by finite differences of its own kinematics.
#include "tools/diagnose/sim/tree_dynamics.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "tests/support/small_world.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using Vector = Eigen::Vector3d;
constexpr Vec3 kGravity{0.4, -0.3, -9.7};

Vector eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }

Vector random_vector(Random& random) {
  return {2 * random.normal(), 2 * random.normal(), random.normal()};
}

/// The arm of three joints (two turn, one slides) with what the laws below ask of it.
class Arm {
 public:
  explicit Arm(const Vec3& gravity = kGravity)
      : model(test::arm("actuator = \"passive\"\n")), tree(model.tree, gravity) {}
  Eigen::Matrix3d mass_at(const Vector& q) {
    JointMatrix M{};
    tree.set_positions(q.data());
    tree.mass_matrix(M);
    Eigen::Matrix3d full;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j)
        full(i, j) = full(j, i) = M[static_cast<std::size_t>(i * kMaxJoints + j)];
    }
    return full;
  }
  Vector bias_at(const Vector& q, const Vector& dq) {
    JointVector h{};
    tree.set_positions(q.data());
    tree.bias(dq.data(), h);
    return {h[0], h[1], h[2]};
  }
  double potential(const Vector& q) {
    tree.set_positions(q.data());
    double sum = 0.0;
    for (int j = 0; j < 3; ++j)
      sum -= model.tree.joints[static_cast<std::size_t>(j)].body.mass *
             eigen(kGravity).dot(eigen(tree.com(j)));
    return sum;
  }
  Vector com_at(const Vector& q, int j) {
    tree.set_positions(q.data());
    return eigen(tree.com(j));
  }

  ModelFolder model;
  TreeDynamics tree;
};

/// d f / d q by central differences; f gives a vector.
template <class F>
Eigen::MatrixXd slope(F&& f, const Vector& q) {
  constexpr double kStep = 1e-6;
  Eigen::MatrixXd out;
  for (int j = 0; j < 3; ++j) {
    const Eigen::VectorXd d =
        (f(q + kStep * Vector::Unit(j)) - f(q - kStep * Vector::Unit(j))) / (2 * kStep);
    if (j == 0) out.resize(d.size(), 3);
    out.col(j) = d;
  }
  return out;
}

TEST(TreeLaws, MassMatrixIsPositiveDefiniteEverywhere) {
  Arm arm;
  Random random(1);
  for (int k = 0; k < 50; ++k)
    EXPECT_EQ(arm.mass_at(random_vector(random)).llt().info(), Eigen::Success);
}

TEST(TreeLaws, TranslationalKineticEnergyIsThatOfTheMassCentres) {
  // without rotational inertia the mass matrix is sum of m J' J
  Arm arm;
  for (TreeJoint& joint : arm.model.tree.joints) joint.body.about_com = {};
  arm.tree = TreeDynamics(arm.model.tree, kGravity);
  Random random(2);
  for (int k = 0; k < 20; ++k) {
    const Vector q = random_vector(random);
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (int j = 0; j < 3; ++j) {
      const Eigen::MatrixXd J =
          slope([&](const Vector& x) -> Eigen::VectorXd { return arm.com_at(x, j); }, q);
      sum += arm.model.tree.joints[static_cast<std::size_t>(j)].body.mass * J.transpose() * J;
    }
    EXPECT_LT((arm.mass_at(q) - sum).norm(), 1e-8);
  }
}

TEST(TreeLaws, BiasAtRestIsTheSlopeOfThePotential) {
  Arm arm;
  Random random(3);
  for (int k = 0; k < 20; ++k) {
    const Vector q = random_vector(random);
    const Eigen::MatrixXd expected = slope(
        [&](const Vector& x) -> Eigen::VectorXd {
          return Eigen::VectorXd::Constant(1, arm.potential(x));
        },
        q);
    EXPECT_LT((arm.bias_at(q, Vector::Zero()) - expected.transpose()).norm(), 1e-7);
  }
}

TEST(TreeLaws, CentrifugalTermsAreThoseOfLagrange) {
  // h_i = sum_jk (dM_ij/dq_k - 1/2 dM_jk/dq_i) dq_j dq_k
  Arm arm({0, 0, 0});
  Random random(4);
  for (int trial = 0; trial < 20; ++trial) {
    const Vector q = random_vector(random), dq = random_vector(random);
    Vector expected = Vector::Zero();
    for (int k = 0; k < 3; ++k) {
      const Vector step = 1e-6 * Vector::Unit(k);
      const Eigen::Matrix3d dM = (arm.mass_at(q + step) - arm.mass_at(q - step)) / 2e-6;
      expected += dM * dq * dq[k];
      expected[k] -= 0.5 * dq.dot(dM * dq);
    }
    EXPECT_LT((arm.bias_at(q, dq) - expected).norm(), 1e-7 * (1.0 + dq.squaredNorm()));
  }
}

TEST(TreeLaws, CentrifugalTermsGrowWithTheSquareOfSpeed) {
  Arm arm({0, 0, 0});
  Random random(5);
  const Vector q = random_vector(random), dq = random_vector(random);
  EXPECT_LT((arm.bias_at(q, 3.0 * dq) - 9.0 * arm.bias_at(q, dq)).norm(), 1e-10);
  EXPECT_LT((arm.bias_at(q, -dq) - arm.bias_at(q, dq)).norm(), 1e-12);
}

TEST(TreeLaws, InverseDynamicsIsMassTimesAccelerationPlusBias) {
  Arm arm;
  Random random(6);
  for (int k = 0; k < 20; ++k) {
    const Vector q = random_vector(random), dq = random_vector(random), ddq = random_vector(random);
    const Vector expected = arm.mass_at(q) * ddq + arm.bias_at(q, dq);
    JointVector tau{};
    arm.tree.inverse_dynamics(dq.data(), ddq.data(), tau);
    EXPECT_LT((Vector(tau[0], tau[1], tau[2]) - expected).norm(), 1e-11);
  }
}

TEST(TreeLaws, AForceOnALinkIsItsJacobianTransposed) {
  Arm arm;
  Random random(7);
  const Vec3 force{1.5, -2.0, 0.7};
  for (int j = 0; j < 3; ++j) {
    const Vector q = random_vector(random), dq = random_vector(random);
    const Eigen::MatrixXd J =
        slope([&](const Vector& x) -> Eigen::VectorXd { return arm.com_at(x, j); }, q);
    arm.tree.set_world_force(j, {0, 0, 0});
    const Vector without = arm.bias_at(q, dq);
    arm.tree.add_world_force(j, force);
    EXPECT_LT((without - arm.bias_at(q, dq) - J.transpose() * eigen(force)).norm(), 1e-7) << j;
    arm.tree.set_world_force(j, {0, 0, 0});
  }
}

TEST(TreeLaws, ABodyPutOnALinkPullsAsItsOwnWeight) {
  Arm arm;
  Random random(8);
  const Vector q = random_vector(random);
  const Vector before = arm.bias_at(q, Vector::Zero());
  add_body(arm.model.tree.joints[1].body, {0.3, arm.model.tree.joints[1].body.com, {}});
  arm.tree = TreeDynamics(arm.model.tree, kGravity);
  const Eigen::MatrixXd J =
      slope([&](const Vector& x) -> Eigen::VectorXd { return arm.com_at(x, 1); }, q);
  const Vector expected = before - 0.3 * J.transpose() * eigen(kGravity);
  EXPECT_LT((arm.bias_at(q, Vector::Zero()) - expected).norm(), 1e-7);
}

TEST(TreeLaws, OneHingeAloneAgreesWithItselfInAChain) {
  // the pendulum is solved in closed form; with a massless slider behind it, by recursion
  const RobotTree lone = test::pendulum("").tree;
  RobotTree chain = lone;
  TreeJoint idle;
  idle.name = "idle", idle.parent = 0, idle.prismatic = true;
  chain.joints.push_back(idle);
  TreeDynamics a(lone, kGravity), b(chain, kGravity);
  for (double q = -3.0; q < 3.0; q += 0.4) {
    const double qs[2] = {q, 0.0}, dqs[2] = {1.3, 0.0};
    JointMatrix Ma{}, Mb{};
    JointVector ha{}, hb{};
    a.set_positions(qs), b.set_positions(qs);
    a.mass_matrix(Ma), b.mass_matrix(Mb);
    a.bias(dqs, ha), b.bias(dqs, hb);
    EXPECT_NEAR(Ma[0], Mb[0], 1e-14);
    EXPECT_NEAR(ha[0], hb[0], 1e-12);
  }
}

}  // namespace
}  // namespace sanso::diagnose
