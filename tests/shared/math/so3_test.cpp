// Rotations and the state: ⊕, ⊖, exponential, logarithm and their derivatives, near zero and near a
// half turn.
#include "shared/math/so3.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "shared/model/state_layout.h"
#include "tests/support/tangent_battery.h"

namespace sanso {
namespace {

constexpr unsigned kSeed = 7;
constexpr double kPi = 3.14159265358979323846;

math::Vec3 random_vector(std::mt19937& rng, double length) {
  std::normal_distribution<double> normal;
  return length * math::Vec3(normal(rng), normal(rng), normal(rng)).normalized();
}

struct Rotations {
  using Point = math::Quat;
  using Tangent = math::Vec3;
  static Point plus(const Point& q, const Tangent& d) { return math::quat_plus(q, d); }
  static Tangent minus(const Point& a, const Point& b) { return math::quat_minus(a, b); }
  static Point random(std::mt19937& rng) { return math::quat_exp(random_vector(rng, 2.0)); }
  static Tangent random_tangent(std::mt19937& rng, double length) {
    return random_vector(rng, length);
  }
};

struct States {
  using Point = model::State;
  using Tangent = model::Tangent;
  static Point plus(const Point& x, const Tangent& d) { return model::plus(x, d); }
  static Tangent minus(const Point& a, const Point& b) { return model::minus(a, b); }
  static Tangent random_tangent(std::mt19937& rng, double length) {
    std::normal_distribution<double> normal;
    Tangent d;
    for (double& c : d) c = normal(rng);
    d.segment<3>(model::kDTheta) = random_vector(rng, length);
    return d;
  }
  static Point random(std::mt19937& rng) {
    return plus(model::neutral_state(), random_tangent(rng, 1.5));
  }
};

template <class Space>
class TangentLaws : public ::testing::Test {};
using Spaces = ::testing::Types<Rotations, States>;
TYPED_TEST_SUITE(TangentLaws, Spaces);

TYPED_TEST(TangentLaws, HoldEverywhere) {
  testing::TangentBattery<TypeParam> battery(kSeed);
  battery.neutral_element();
  for (const double length : {0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 1.0, 3.0})
    battery.round_trips(length, 1e-13);
  // near the half turn the logarithm's direction rests on sin(pi - a): absolute error stays at
  // rounding level
  battery.round_trips(kPi - 1e-6, 1e-12);
}

TYPED_TEST(TangentLaws, MovingByATangentHasTheExpectedDerivative) {
  // f(x) = x ⊕ d: identity on linear parts, and for the rotation Exp(-d), which turns body axes
  using Tangent = typename TypeParam::Tangent;
  testing::TangentBattery<TypeParam> battery(kSeed);
  std::mt19937 rng(kSeed);
  constexpr int n = Tangent::RowsAtCompileTime, at = n == 3 ? 0 : 3;
  for (const double length : {1e-8, 0.5, 3.0}) {
    const auto x = TypeParam::random(rng);
    const Tangent d = TypeParam::random_tangent(rng, length);
    Eigen::Matrix<double, n, n> J = Eigen::Matrix<double, n, n>::Identity();
    const math::Vec3 turn = d.template segment<3>(at);
    J.template block<3, 3>(at, at) = math::rotation_matrix(math::quat_exp(-turn));
    battery.derivative_matches([&](const auto& y) { return TypeParam::plus(y, d); }, x, J, 1e-8);
  }
}

TEST(So3, RightJacobianInverseUndoesTheDerivativeOfExp) {
  std::mt19937 rng(kSeed);
  for (const double length : {0.0, 1e-7, 5e-5, 2e-4, 0.3, 2.0, 3.1}) {
    const math::Vec3 r = random_vector(rng, length);
    math::Mat3 J;
    for (int i = 0; i < 3; ++i) {
      constexpr double h = 1e-6;
      const math::Vec3 e = h * math::Vec3::Unit(i);
      J.col(i) = math::quat_minus(math::quat_exp(r + e), math::quat_exp(r - e)) / (2 * h);
    }
    EXPECT_LE((J * math::right_jacobian_inverse(r) - math::Mat3::Identity()).norm(), 1e-8)
        << "length " << length;
  }
}

TEST(So3, QuaternionAndMatrixAgree) {
  std::mt19937 rng(kSeed);
  for (int k = 0; k < 100; ++k) {
    const math::Quat a = Rotations::random(rng), b = Rotations::random(rng);
    const math::Mat3 product = math::rotation_matrix(a) * math::rotation_matrix(b);
    EXPECT_LE((math::rotation_matrix(math::quat_multiply(a, b)) - product).norm(), 1e-14);
    const Eigen::Quaterniond eigen(a[0], a[1], a[2], a[3]);
    EXPECT_LE((math::rotation_matrix(a) - eigen.toRotationMatrix()).norm(), 1e-14)
        << "second witness";
  }
}

TEST(So3, BothSignsOfAQuaternionAreTheSameRotation) {
  std::mt19937 rng(kSeed);
  const math::Quat a = Rotations::random(rng), b = Rotations::random(rng);
  EXPECT_LE((math::quat_minus(a, b) - math::quat_minus(math::Quat(-a), b)).norm(), 1e-14);
}

}  // namespace
}  // namespace sanso
