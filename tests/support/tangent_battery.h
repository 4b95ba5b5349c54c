// One battery of laws for every space with ⊕ and ⊖: round trips, derivatives against differences on
// the tangent.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <random>

namespace sanso::testing {

/// A space: `Point`, `Tangent` (fixed-size Eigen vector), and how to move and to compare.
///   Point plus(const Point&, const Tangent&)   Tangent minus(const Point& a, const Point& b): b ⊕
///   result = a
template <class Space>
class TangentBattery {
 public:
  using Point = typename Space::Point;
  using Tangent = typename Space::Tangent;
  static constexpr int kSize = Tangent::RowsAtCompileTime;

  explicit TangentBattery(unsigned seed) : seed_(seed), rng_(seed) {}

  /// (x ⊕ d) ⊖ x = d for tangents of the given length of the rotation part (below pi), and x ⊕ (y ⊖
  /// x) = y.
  void round_trips(double rotation_length, double tolerance) {
    for (int k = 0; k < 200; ++k) {
      const Point x = Space::random(rng_), y = Space::random(rng_);
      const Tangent d = Space::random_tangent(rng_, rotation_length);
      EXPECT_LE((Space::minus(Space::plus(x, d), x) - d).norm(), tolerance * (1 + d.norm()))
          << where(k);
      EXPECT_LE(Space::minus(Space::plus(x, Space::minus(y, x)), y).norm(),
                tolerance * (1 + d.norm()))
          << where(k);
    }
  }

  void neutral_element() {
    const Point x = Space::random(rng_);
    EXPECT_LE(Space::minus(x, x).norm(), 1e-14);
    EXPECT_LE(Space::minus(Space::plus(x, Tangent::Zero()), x).norm(), 1e-14);
  }

  /// A function's Jacobian (tangent out, tangent in) against central differences on the tangent;
  /// step 1e-6 leaves 1e-9.
  template <class Function>
  void derivative_matches(const Function& f, const Point& x,
                          const Eigen::Matrix<double, kSize, kSize>& J, double tolerance) {
    constexpr double h = 1e-6;
    for (int i = 0; i < kSize; ++i) {
      const auto f_at = [&](double s) { return f(Space::plus(x, s * h * Tangent::Unit(i))); };
      const Tangent difference = Space::minus(f_at(+1), f_at(-1)) / (2 * h);
      EXPECT_LE((difference - J.col(i)).norm(), tolerance) << "column " << i << ", seed " << seed_;
    }
  }

 private:
  std::string where(int k) const {
    return "sample " + std::to_string(k) + ", seed " + std::to_string(seed_);
  }
  unsigned seed_;
  std::mt19937 rng_;
};

}  // namespace sanso::testing
