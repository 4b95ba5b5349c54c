// Screening: the true effect first, chance rarely, correlations that are correlations.
#include "tools/diagnose/fit/screen.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/noisy_world.h"

namespace sanso::diagnose {
namespace {

using namespace test;

const std::vector<std::string> kTried{"coulomb_friction", "viscous_friction", "cable_spring",
                                      "command_delay", "encoder_offset"};

/// A comparison, and what the screening of its nominal model says.
struct Screened {
  explicit Screened(SmallComparison comparison) : c(std::move(comparison)) {
    const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
    const FitResult calibrated = fit(around, nominal(c), 7);
    screening = screen(around, calibrated.model, calibrated.r, c.all(), Random(1));
  }
  const Candidate& first() const { return c.library[screening.ranking().front()]; }
  SmallComparison c;
  Screening screening;
};

TEST(Screen, RanksWhatWasHiddenFirst) {
  for (const EffectEntry& e : {hidden("coulomb_friction", "a", {{"coulomb", 0.06}}),
                               hidden("viscous_friction", "a", {{"viscous", 0.15}}),
                               hidden("command_delay", "a", {{"delay", 0.02}})}) {
    const Screened s(compared(pendulum(kNoisyServo), {e}, kTried, 1));
    EXPECT_EQ(s.first().effect, e.id);
    EXPECT_LT(s.screening.best(s.screening.ranking().front())->p_family, 0.01) << e.id;
  }
}

TEST(Screen, TellsTheJointThatWasChanged) {
  for (const std::string joint : {"a", "b"}) {
    const Screened s(compared(two_links(kNoisyServo),
                              {hidden("coulomb_friction", joint, {{"coulomb", 0.08}})}, kTried, 2));
    EXPECT_EQ(s.first().where, std::vector<std::string>{joint}) << s.first().title();
  }
}

TEST(Screen, FindsNothingInCleanDataNearlyAlways) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Screened s(compared(pendulum(kNoisyServo), {}, kTried, seed));
    found += std::any_of(s.screening.probes.begin(), s.screening.probes.end(),
                         [](const ProbeScore& p) { return p.p_family < 0.01; });
  }
  EXPECT_LE(found, 1);
}

// A force between the axes of a link: the probe of either axis has a part of it. An offset of the
// encoder pushes alike, and one probe is all it has.
TEST(Screen, ADirectionCountsWithAllItsAxes) {
  const Screened s(compared(pendulum(kNoisyServo),
                            {hidden("tether", "arm", {{"x", 0.3}, {"z", -2.0}})},
                            {"tether", "encoder_offset", "cable_spring"}, 1, 3, 8.0));
  const ProbeScore& force = *s.screening.best(s.c.of("tether"));
  EXPECT_GT(std::pow(force.together, 2),
            std::pow(force.score, 2) + std::pow(s.screening.critical, 2));
  EXPECT_EQ(s.first().effect, "tether");
  for (const ProbeScore& p : s.screening.probes) {
    EXPECT_GE(p.together, p.score);
    if (s.c.library[p.candidate].effect == "encoder_offset") {
      EXPECT_EQ(p.together, p.score);
    }
  }
}

class OneScreening : public ::testing::Test {
 protected:
  Screened s_{compared(pendulum(kNoisyServo),
                       {hidden("coulomb_friction", "a", {{"coulomb", 0.06}})}, kTried, 1)};
};

TEST_F(OneScreening, CorrelationsAreCorrelations) {
  const Eigen::MatrixXd& R = s_.screening.correlation;
  ASSERT_EQ(R.rows(), static_cast<Eigen::Index>(s_.screening.probes.size()));
  EXPECT_LT((R - R.transpose()).norm(), 1e-6);
  EXPECT_LE(R.cwiseAbs().maxCoeff(), 1.0 + 1e-6);
  for (Eigen::Index i = 0; i < R.rows(); ++i) {
    if (s_.screening.probes[i].signature > 1.0) {
      EXPECT_NEAR(R(i, i), 1.0, 1e-3);
    }
  }
}

TEST_F(OneScreening, RankingIsByScoreAndHoldsEveryCandidateOnce) {
  std::vector<std::size_t> ranking = s_.screening.ranking();
  for (std::size_t i = 1; i < ranking.size(); ++i)
    EXPECT_GE(s_.screening.best(ranking[i - 1])->score, s_.screening.best(ranking[i])->score);
  std::sort(ranking.begin(), ranking.end());
  EXPECT_EQ(ranking, s_.c.all());
  EXPECT_EQ(s_.screening.best(9999), nullptr);
}

TEST_F(OneScreening, ScoresAndFamilyPsBelongTogether) {
  for (const ProbeScore& p : s_.screening.probes) {
    EXPECT_GE(p.score, 0.0);
    EXPECT_GT(p.p_family, 0.0);
    EXPECT_LE(p.p_family, 1.0);
    for (const ProbeScore& q : s_.screening.probes) {
      if (p.score > q.score) {
        EXPECT_LE(p.p_family, q.p_family);
      }
    }
    if (p.score > 1.5 * s_.screening.critical) {
      EXPECT_LT(p.p_family, 0.02);
    }
  }
}

TEST_F(OneScreening, SimilarityIsSymmetricAndOneToItself) {
  for (const std::size_t a : s_.c.all()) {
    for (const std::size_t b : s_.c.all())
      EXPECT_NEAR(s_.screening.similarity(a, b), s_.screening.similarity(b, a), 1e-6);
  }
  const std::size_t best = s_.screening.ranking().front();
  EXPECT_NEAR(s_.screening.similarity(best, best), 1.0, 1e-3);
}

TEST_F(OneScreening, ChannelsAreNeverTakenForBetterThanTheirFloor) {
  for (std::size_t c = 0; c < s_.c.problem->channels.size(); ++c)
    EXPECT_GE(s_.screening.scales.sigma[c], s_.c.problem->channels[c].floor * (1 - 1e-9));
}

/// The level of the positions of a rubbing pendulum whose servo is stiffer than it says.
double level_of_positions(bool duty) {
  const ModelFolder model = pendulum(kNoisyServo);
  const ModelFolder world = hiding(model, {hidden("servo_p_gain", "a", {{"gain", 1.4}}),
                                           hidden("coulomb_friction", "a", {{"coulomb", 0.03}}),
                                           hidden("encoder_offset", "a", {{"offset", 0.01}})});
  std::vector<recording::Recording> recordings;
  for (int k = 0; k < 2; ++k) {
    const Drive drive =
        make_test_drive(world, 4.0, 0.01, [k](int j, double t) { return wave(k, j, t); });
    recordings.push_back(record(world, drive,
                                {.file = "rec_" + std::to_string(k) + ".csv",
                                 .duty = duty,
                                 .noise_seed = 91 + static_cast<std::uint64_t>(k)}));
  }
  const Screened s(SmallComparison(model, recordings, noise_of(model), {}));
  return s.screening.scales.sigma[0];
}

TEST(Screen, WhatElseIsRecordedMakesNoPositionLessTrusted) {
  EXPECT_LT(level_of_positions(true), 1.1 * level_of_positions(false));
}

}  // namespace
}  // namespace sanso::diagnose
