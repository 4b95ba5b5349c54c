// Is there physics in a torque? A law of the state is found and described, noise is not.
#include "tools/diagnose/verdict/predictability.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sanso::diagnose {
namespace {

/// 400 windows of a joint that swings; missing torque = law(sample) + noise of 0.02 N m.
template <class Law>
std::vector<TorqueSample> samples(const Law& law, std::uint64_t seed) {
  Random random(seed);
  std::vector<TorqueSample> out;
  for (int k = 0; k < 400; ++k) {
    TorqueSample s;
    s.t = 0.1 * k;
    s.row = static_cast<std::size_t>(10 * k);
    s.q = 0.8 * std::sin(1.3 * s.t) + 0.3 * std::sin(4.1 * s.t);
    s.dq = 1.04 * std::cos(1.3 * s.t) + 1.23 * std::cos(4.1 * s.t);
    s.ddq = -1.35 * std::sin(1.3 * s.t) - 5.04 * std::sin(4.1 * s.t);
    s.motor = 0.2 * s.q + 0.02 * s.ddq;
    s.sigma = 0.02;
    s.missing = law(s) + 0.02 * random.normal();
    out.push_back(s);
  }
  return out;
}

double sign(double x) { return x > 0 ? 1.0 : -1.0; }

TEST(Predictability, FindsALawWhateverItsForm) {
  const auto found = [](const std::vector<TorqueSample>& s) {
    return predictability(s, 0, Random(1), Settings{});
  };
  for (const Predictability& p :
       {found(samples([](const TorqueSample& s) { return -0.1 * sign(s.dq); }, 1)),
        found(samples([](const TorqueSample& s) { return 0.1 * std::sin(2 * s.q); }, 2)),
        found(samples([](const TorqueSample& s) { return 0.02 * s.ddq; }, 3))}) {
    EXPECT_GT(p.explained, 0.5);
    EXPECT_LT(p.p, 0.02);
    EXPECT_GT(p.torque_rms, 2.0 * p.noise_rms);
  }
}

TEST(Predictability, FindsNothingInNoise) {
  int significant = 0;
  for (std::uint64_t seed = 10; seed < 30; ++seed) {
    const Predictability p = predictability(samples([](const TorqueSample&) { return 0.0; }, seed),
                                            0, Random(seed), Settings{});
    EXPECT_LT(p.explained, 0.1) << seed;
    EXPECT_NEAR(p.torque_rms / p.noise_rms, 1.0, 0.2);
    significant += p.p < 0.05;
  }
  EXPECT_LE(significant, 4) << "1 of 20 is expected";
}

TEST(Predictability, SaysNothingOfTooLittleAndOfOtherJoints) {
  auto few = samples([](const TorqueSample& s) { return s.q; }, 4);
  EXPECT_EQ(predictability(few, 1, Random(1), Settings{}).p, 1.0);
  few.resize(39);
  EXPECT_EQ(predictability(few, 0, Random(1), Settings{}).p, 1.0);
}

TEST(Predictability, IsTheSameForOneSeed) {
  const auto s = samples([](const TorqueSample& x) { return 0.05 * x.dq; }, 5);
  const Predictability a = predictability(s, 0, Random(9), Settings{}),
                       b = predictability(s, 0, Random(9), Settings{});
  EXPECT_EQ(a.explained, b.explained);
  EXPECT_EQ(a.p, b.p);
}

TEST(SparseFormula, DescribesFrictionByTheSignOfSpeed) {
  const SparseFormula f = sparse_formula(
      samples([](const TorqueSample& s) { return -0.12 * sign(s.dq); }, 6), 0, RemainsSettings{});
  EXPECT_NE(f.text.find("sign(dq)"), std::string::npos) << f.text;
  EXPECT_NE(f.text.find("0.12"), std::string::npos) << f.text;
  EXPECT_GT(f.explained, 0.9);
}

TEST(SparseFormula, IsEmptyOfNoiseNearlyAlways) {
  int terms = 0;
  for (std::uint64_t seed = 40; seed < 60; ++seed)
    terms += !sparse_formula(samples([](const TorqueSample&) { return 0.0; }, seed), 0,
                             RemainsSettings{})
                  .text.empty();
  EXPECT_LE(terms, 4);
}

TEST(SparseFormula, ExplainsMoreOfALawThanOfLess) {
  const auto share = [](double size) {
    return sparse_formula(samples([&](const TorqueSample& s) { return size * std::sin(s.q); }, 7),
                          0, RemainsSettings{})
        .explained;
  };
  EXPECT_GT(share(0.3), share(0.05));
}

TEST(ShapeCurves, ShowALawAgainstItsOwnQuantityMost) {
  const auto curves =
      shape_curves(samples([](const TorqueSample& s) { return 0.1 * s.dq * s.dq; }, 8), 0);
  ASSERT_GE(curves.size(), 4u);
  const ShapeCurve* best = &curves[0];
  for (const ShapeCurve& c : curves) best = c.explained > best->explained ? &c : best;
  EXPECT_EQ(best->name, "velocity");
}

}  // namespace
}  // namespace sanso::diagnose
