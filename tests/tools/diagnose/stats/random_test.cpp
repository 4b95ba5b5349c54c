// The generator: distributions, independence of streams, one sequence everywhere.
#include "tools/diagnose/stats/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/tools/diagnose/stats/made_series.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Largest distance between the empirical distribution of `u` and the uniform one (Kolmogorov).
double distance_from_uniform(std::vector<double> u) {
  std::sort(u.begin(), u.end());
  const auto n = static_cast<double>(u.size());
  double distance = 0.0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const auto rank = static_cast<double>(i);
    distance = std::max({distance, std::abs(u[i] - rank / n), std::abs(u[i] - (rank + 1) / n)});
  }
  return distance;
}

TEST(Random, UniformIsUniformAndBelowOne) {
  Random random(kSeed);
  std::vector<double> u(20000);
  for (double& v : u) v = random.uniform();
  EXPECT_LT(distance_from_uniform(u), 1.95 / std::sqrt(20000.0));  // 1 in 1000
  EXPECT_GE(*std::min_element(u.begin(), u.end()), 0.0);
  EXPECT_LT(*std::max_element(u.begin(), u.end()), 1.0);
}

TEST(Random, NormalIsNormalInItsTailsToo) {
  std::vector<double> p;
  for (const double z : white(20000, 1)) p.push_back(normal_tail(z));
  EXPECT_LT(distance_from_uniform(p), 1.95 / std::sqrt(20000.0));
  EXPECT_NEAR(
      static_cast<double>(std::count_if(p.begin(), p.end(), [](double v) { return v < 0.00135; })),
      27.0, 4.0 * std::sqrt(27.0));
}

TEST(Random, BelowReachesEveryNumberEquallyOften) {
  Random random(kSeed, 2);
  std::array<int, 7> count{};
  for (int k = 0; k < 7000; ++k) ++count.at(static_cast<std::size_t>(random.below(7)));
  double energy = 0.0;
  for (const int c : count) energy += (c - 1000.0) * (c - 1000.0) / 1000.0;
  EXPECT_GT(chi_square_tail(energy, 6), 1e-3);
}

TEST(Random, SignsAreBalanced) {
  Random random(kSeed, 3);
  double sum = 0.0;
  for (int k = 0; k < 10000; ++k) {
    const double s = random.sign();
    ASSERT_EQ(std::abs(s), 1.0);
    sum += s;
  }
  EXPECT_LT(std::abs(sum), 3.3 * 100.0);
}

TEST(Random, NeighbouringStreamsAndSeedsAreIndependent) {
  for (std::uint64_t k = 0; k < 20; ++k) {
    EXPECT_LT(std::abs(correlation(white(2000, k), white(2000, k + 1))), 4.0 / std::sqrt(2000.0));
    Random a(k), b(k + 1);
    std::vector<double> x, y;
    for (int i = 0; i < 2000; ++i) x.push_back(a.normal()), y.push_back(b.normal());
    EXPECT_LT(std::abs(correlation(x, y)), 4.0 / std::sqrt(2000.0));
  }
}

TEST(Random, IsTheSameSequenceOnEveryMachine) {
  // SplitMix64 by hand: state = mix(seed) ^ mix(stream golden + 1), then mix(state += golden)
  const auto mix = [](std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  };
  constexpr std::uint64_t kGolden = 0x9E3779B97F4A7C15ULL;
  std::uint64_t state = mix(11) ^ mix(5 * kGolden + 1);
  Random random(11, 5);
  for (int k = 0; k < 5; ++k) EXPECT_EQ(random.bits(), mix(state += kGolden));
}

}  // namespace
}  // namespace sanso::diagnose
