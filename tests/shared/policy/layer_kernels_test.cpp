// The arithmetic of the layer sum: its order of additions, the reflex' sign, and the two ways to
// write the reflex.
#include "shared/policy/layer_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "shared/policy/layer_sum.h"

namespace sanso::policy {
namespace {

double exponential(double v) { return std::exp(v); }

TEST(LayerKernels, AffineAddsColumnAfterColumn) {
  std::array<double, model::kNu> u{}, out{};
  std::array<double, model::kNdx> dx{};
  const auto gain = [](int i, int j) { return 0.1 * i - 0.37 * j + 1.0 / (1 + i + j); };
  for (int i = 0; i < model::kNu; ++i) u[i] = 0.3 * i;
  for (int j = 0; j < model::kNdx; ++j) dx[j] = std::sin(j);
  affine_kernel(u, gain, dx, out);
  for (int i = 0; i < model::kNu; ++i) {
    double sum = u[i];
    for (int j = 0; j < model::kNdx; ++j) sum += gain(i, j) * dx[j];
    EXPECT_EQ(out[i], sum) << i;
  }
  affine_kernel(u, gain, dx, u);
  EXPECT_EQ(u, out) << "in place";
}

TEST(LayerKernels, TheReflexPushesAwayFromBothLimits) {
  const ReflexSettings s;
  const auto at = [&](double q) { return reflex_kernel(q, -1.0, 1.5, s, exponential); };
  EXPECT_NEAR(at(1.5), -s.gain / 2, 1e-9);
  EXPECT_NEAR(at(-1.0), s.gain / 2, 1e-9);
  EXPECT_NEAR(at(3.0), -s.gain, 1e-6);
  EXPECT_NEAR(at(0.25), 0.0, 1e-9);
}

TEST(LayerKernels, BothWaysToWriteTheReflexAgreeToRounding) {
  const ReflexSettings s;
  for (double q = -2.0; q < 2.5; q += 0.01)
    EXPECT_NEAR(reflex_complement_kernel(q, -1.0, 1.5, s, exponential),
                reflex_kernel(q, -1.0, 1.5, s, exponential), 1e-16)
        << q;
}

TEST(LayerKernels, TheComplementKeepsDigitsWhereTheOtherHasNone) {
  const ReflexSettings s{.gain = 0.1, .sharpness = 100.0};
  const double q = 0.5, exact = s.gain * (std::exp(-150.0) - std::exp(-100.0));
  EXPECT_NEAR(reflex_complement_kernel(q, -1.0, 1.5, s, exponential), exact, 1e-12 * -exact);
}

TEST(LayerSwitches, TheMaskHoldsEverySwitch) {
  for (unsigned mask = 0; mask <= LayerSwitches::kAll; ++mask)
    EXPECT_EQ(LayerSwitches::from_mask(mask).mask(), mask);
  EXPECT_EQ(LayerSwitches{}.mask(), LayerSwitches::kAll);
  EXPECT_EQ((LayerSwitches{.lower = false}.mask()), 14);
  EXPECT_EQ((LayerSwitches{.reflex = false}.mask()), 7);
}

}  // namespace
}  // namespace sanso::policy
