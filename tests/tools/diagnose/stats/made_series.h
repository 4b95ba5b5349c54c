// Series with known properties for the tests of the statistics; every one from a printed seed.
#pragma once

#include <cmath>
#include <vector>

#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose::test {

inline constexpr std::uint64_t kSeed = 20240607;

/// n independent standard normal values.
inline std::vector<double> white(int n, std::uint64_t stream) {
  Random random(kSeed, stream);
  std::vector<double> x(static_cast<std::size_t>(n));
  for (double& v : x) v = random.normal();
  return x;
}

/// x_k = a x_{k-1} + e_k with e standard normal.
inline std::vector<double> coloured(int n, double a, std::uint64_t stream) {
  std::vector<double> x = white(n, stream);
  for (std::size_t i = 1; i < x.size(); ++i) x[i] += a * x[i - 1];
  return x;
}

/// scale * x + shift.
inline std::vector<double> affine(std::vector<double> x, double scale, double shift) {
  for (double& v : x) v = scale * v + shift;
  return x;
}

/// The same entries in another order (Fisher and Yates).
inline std::vector<double> shuffled(std::vector<double> x, std::uint64_t stream) {
  Random random(kSeed, stream);
  for (std::size_t i = x.size(); i > 1; --i)
    std::swap(x[i - 1], x[static_cast<std::size_t>(random.below(static_cast<int>(i)))]);
  return x;
}

/// x with about `share` of its cells empty, by NaN and by infinity.
inline std::vector<double> with_holes(std::vector<double> x, double share, std::uint64_t stream) {
  Random random(kSeed, stream);
  for (double& v : x) {
    if (random.uniform() < share) v = random.sign() > 0 ? std::nan("") : INFINITY;
  }
  return x;
}

}  // namespace sanso::diagnose::test
