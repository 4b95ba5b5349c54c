// The methods that the diagnosis is compared with: real ones, on known answers.
#include "tools/bench/diagnose/baselines.h"

#include <gtest/gtest.h>

#include "tools/diagnose/stats/random.h"

namespace sanso::bench {
namespace {

/// Five groups of rows: one nuisance and four probes, error = -(amounts . probes) + noise.
diagnose::FirstLook made(const Eigen::VectorXd& amounts) {
  constexpr int kGroups = 5, kRows = 200, kProbes = 4;
  diagnose::FirstLook look;
  look.effect = {"viscous_friction", "coulomb_friction", "backlash", "cogging"};
  using diagnose::Family;
  look.family = {Family::friction, Family::friction, Family::transmission, Family::transmission};
  look.z.assign(kProbes, 0.0);
  look.nuisances = 1;
  look.nuisance_precision = diagnose::Settings{}.tolerances.precision;
  diagnose::Random random(11);
  for (int g = 0; g < kGroups; ++g) {
    Eigen::MatrixXd columns(kRows, 1 + kProbes + 1);
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < 1 + kProbes; ++c) columns(r, c) = random.normal();
      // two kinds of friction look alike
      columns(r, 2) = 0.8 * columns(r, 1) + 0.6 * columns(r, 2);
      columns(r, 1 + kProbes) = random.normal();
    }
    columns.col(1 + kProbes) -= columns.middleCols(1, kProbes) * amounts;
    look.by_group.emplace_back(columns.transpose() * columns);
  }
  return look;
}

TEST(Baselines, NothingIsNamedWhereTheErrorIsNoise) {
  const diagnose::FirstLook look = made(Eigen::Vector4d::Zero());
  EXPECT_TRUE(largest_score(look).empty());
  EXPECT_TRUE(fit_everything(look).empty());
  EXPECT_TRUE(sparse_regression(look).empty());
  EXPECT_TRUE(friction_ladder(look).empty());
}

TEST(Baselines, TwoEffectsAreFoundByTheMethodsThatCan) {
  const diagnose::FirstLook look = made(Eigen::Vector4d(0.0, 1.0, 0.0, 0.8));
  const Names both{"coulomb_friction", "cogging"}, by_t{"cogging", "coulomb_friction"};
  EXPECT_EQ(largest_score(look), Names{"coulomb_friction"});
  EXPECT_EQ(fit_everything(look), by_t);
  EXPECT_EQ(sparse_regression(look), both);
  EXPECT_EQ(friction_ladder(look), Names{"coulomb_friction"});
}

TEST(Baselines, WithoutGroupsNothingIsNamed) {
  EXPECT_TRUE(sparse_regression(diagnose::FirstLook{}).empty());
}

}  // namespace
}  // namespace sanso::bench
