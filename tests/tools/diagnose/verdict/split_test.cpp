// Fitted and held out are all data and share none; where the joint was changed is where it is said.
#include <gtest/gtest.h>

#include <algorithm>

#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/verdict/heldout.h"
#include "tools/diagnose/verdict/location_map.h"

namespace sanso::diagnose {
namespace {

/// Sources of ten seconds at 100 Hz, one a condition of `conditions`.
std::vector<Source> sources(const std::vector<std::string>& conditions) {
  std::vector<Source> out;
  for (std::size_t k = 0; k < conditions.size(); ++k) {
    Source s;
    s.file = "folder/rec_" + std::to_string(k) + ".csv";
    s.condition = conditions[k];
    for (int row = 0; row <= 1000; ++row) s.drive.t.push_back(5.0 + 0.01 * row);
    out.push_back(s);
  }
  return out;
}

/// Shots of half a second over all sources; positions of two joints compared at every 5th row.
Problem problem_of(std::vector<Source> all) {
  Comparison p;
  p.joints = {"hip", "knee"};
  p.channels.resize(2);
  p.channels[1].joint = 1;
  p.sources = std::move(all);
  for (std::size_t s = 0; s < p.sources.size(); ++s) {
    for (std::size_t first = 0; first + 50 <= 1000; first += 50) {
      Shot shot;
      shot.source = s;
      shot.window.first = first, shot.window.last = first + 50;
      shot.stride = 5, shot.rows = 10;
      shot.offset = p.size;
      p.size += 2 * shot.rows;
      p.shots.push_back(shot);
    }
  }
  const auto entries = static_cast<Eigen::Index>(p.size);
  return {std::make_shared<const Comparison>(std::move(p)), Scales{{1.0, 1.0}},
          StepCorrection{Eigen::VectorXd::LinSpaced(entries, 0.0, static_cast<double>(entries))}};
}

const std::vector<std::vector<std::string>>& cases() {
  static const std::vector<std::vector<std::string>> all{{""},
                                                         {"", ""},
                                                         {"", "", ""},
                                                         {"", "", "", "", "", "", ""},
                                                         {"x", "y"},
                                                         {"x", "y", "x"},
                                                         {"x", "x", "y", "y", "z"}};
  return all;
}

using Place = std::pair<std::size_t, std::size_t>;  // source, first row

std::vector<Place> places(const Problem& p) {
  std::vector<Place> out;
  for (const Shot& s : p->shots) out.emplace_back(s.source, s.window.first);
  return out;
}

TEST(Split, FittedAndHeldOutShareNothing) {
  for (const auto& conditions : cases()) {
    const Problem all = problem_of(sources(conditions));
    const Split split = make_split(all->sources);
    const auto fitted = places(restricted(all, split.fitted)),
               held = places(restricted(all, split.heldout));
    for (const Place& p : held)
      EXPECT_EQ(std::count(fitted.begin(), fitted.end(), p), 0) << p.first << ", " << p.second;
    EXPECT_FALSE(fitted.empty());
    EXPECT_FALSE(held.empty());
  }
}

TEST(Split, FittedAndHeldOutAreAllButWhatLiesAcrossTheCut) {
  for (const auto& conditions : cases()) {
    const Problem all = problem_of(sources(conditions));
    const Split split = make_split(all->sources);
    const std::size_t together =
        restricted(all, split.fitted)->shots.size() + restricted(all, split.heldout)->shots.size();
    const std::size_t cut = conditions.size() == 1 ? 1 : 0;
    EXPECT_EQ(together + cut, all->shots.size()) << conditions.size() << " recordings";
  }
}

TEST(Split, HoldsOutTheSmallestConditionWhole) {
  const Split split = make_split(sources({"loaded", "free", "loaded"}));
  EXPECT_EQ(split.heldout_names, std::vector<std::string>{"rec_1"});
  EXPECT_FALSE(split.last_part);
  EXPECT_EQ(split.fitted.until[1], 0.0);
  EXPECT_EQ(split.fitted.until[0], 1.0);
  EXPECT_EQ(split.fitted.until[2], 1.0);
}

TEST(Split, HoldsOutAThirdOfManyRecordingsAndTheEndOfOne) {
  for (std::size_t n = 2; n <= 12; ++n) {
    const Split split = make_split(sources(std::vector<std::string>(n, "")));
    EXPECT_EQ(split.heldout_names.size(), std::max<std::size_t>(1, n / 3)) << n;
  }
  const Split one = make_split(sources({""}));
  EXPECT_NEAR(one.fitted.until[0], 2.0 / 3.0, 1e-12);
  EXPECT_EQ(one.heldout.until[0], 1.0);
  EXPECT_TRUE(one.last_part);
}

TEST(Restricted, KeepsEveryShotsOwnEntries) {
  const Problem all = problem_of(sources({"x", "y"}));
  const Problem held = restricted(all, make_split(all->sources).heldout);
  std::size_t expected = 0;
  for (const Shot& shot : held->shots) {
    EXPECT_EQ(shot.offset, expected);
    expected += shot.rows * held->channels.size();
    const auto same = std::find_if(all->shots.begin(), all->shots.end(), [&](const Shot& s) {
      return s.source == shot.source && s.window.first == shot.window.first;
    });
    EXPECT_EQ(rows_of(held.correction.error, shot, 0, 2),
              rows_of(all.correction.error, *same, 0, 2));
  }
  EXPECT_EQ(held->size, expected);
  EXPECT_EQ(static_cast<std::size_t>(held.correction.error.size()), expected);
}

TEST(Restricted, ToNothingIsTheWholeProblem) {
  const Problem all = problem_of(sources({""}));
  EXPECT_EQ(restricted(all, {{0.5}, {0.5}})->shots.size(), all->shots.size());
}

/// Regimes "early" (first half of every second) and "late".
Regimes halves(const Comparison& p) {
  Regimes r;
  r.names = {"early", "late"};
  for (const Source& s : p.sources) {
    std::vector<char> early, late;
    for (std::size_t k = 0; k < s.drive.t.size(); ++k) {
      early.push_back(k % 100 < 50);
      late.push_back(k % 100 >= 50);
    }
    r.mask.push_back({{early, late}, {early, late}});
  }
  return r;
}

/// Noise of deviation 1; times `factor` at one joint in one half.
Eigen::VectorXd errors(const Comparison& p, const Regimes& regimes, std::size_t joint,
                       std::size_t regime, double factor, std::uint64_t seed) {
  Random random(seed);
  Eigen::VectorXd r(static_cast<Eigen::Index>(p.size));
  for (const Shot& shot : p.shots) {
    for (std::size_t c = 0; c < 2; ++c) {
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const bool here =
            c == joint && regimes.in(shot.source, joint, regime, recorded_row(shot, k));
        rows_of(r, shot, c)[k] = (here ? factor : 1.0) * random.normal();
      }
    }
  }
  return r;
}

TEST(Locate, FindsTheJointAndRegimeThatWereChanged) {
  const Problem made = problem_of(sources({"", ""}));
  const Comparison& p = *made;
  const Regimes regimes = halves(p);
  for (std::size_t joint = 0; joint < 2; ++joint) {
    for (std::size_t regime = 0; regime < 2; ++regime) {
      const LocationMap map = locate(p, regimes, errors(p, regimes, joint, regime, 3.0, 5));
      ASSERT_FALSE(map.cells.empty());
      EXPECT_EQ(map.cells[0].where, p.joints[joint]);
      EXPECT_EQ(map.cells[0].regime, regimes.names[regime]);
      EXPECT_LT(map.cells[0].q_value, 0.05);
      EXPECT_NEAR(map.cells[0].lift, 9.0, 3.0);
      EXPECT_NEAR(map.heat[joint][regime], 9.0, 2.0);
      EXPECT_GT(map.cells[0].share, 0.9);
    }
  }
}

TEST(Locate, CallsNothingInNoiseButRarely) {
  const Problem made = problem_of(sources({"", ""}));
  const Comparison& p = *made;
  const Regimes regimes = halves(p);
  int called = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const LocationMap map = locate(p, regimes, errors(p, regimes, 0, 0, 1.0, 100 + seed));
    called += std::any_of(map.cells.begin(), map.cells.end(),
                          [](const LocationCell& c) { return c.q_value < 0.05; });
  }
  EXPECT_LE(called, 8) << "3 of 60 are expected";
}

TEST(Locate, TimeStripAndHeatAreMeanSquares) {
  const Problem made = problem_of(sources({""}));
  const Comparison& p = *made;
  const Regimes regimes = halves(p);
  const LocationMap map =
      locate(p, regimes, Eigen::VectorXd::Constant(static_cast<Eigen::Index>(p.size), 2.0));
  for (const auto& joint : map.time_strip) {
    for (const double e : joint) EXPECT_DOUBLE_EQ(e, 4.0);
  }
  for (const auto& joint : map.heat) {
    for (const double e : joint) EXPECT_DOUBLE_EQ(e, 4.0);
  }
}

TEST(Locate, ShotsStandOneAfterTheOtherInTime) {
  const Problem made = problem_of(sources({"", "", ""}));
  const Comparison& p = *made;
  const LocationMap map =
      locate(p, halves(p), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(p.size)));
  EXPECT_EQ(map.shot_time.size(), p.shots.size());
  EXPECT_TRUE(std::is_sorted(map.shot_time.begin(), map.shot_time.end()));
  EXPECT_NEAR(map.shot_time.front(), 0.0, 1e-12);
}

TEST(FitScore, ExplainedGrowsAsTheErrorFallsAndStaysWithinOne) {
  double before = -2.0;
  for (double patched = 0.3; patched >= 0.0; patched -= 0.01) {
    const double e = FitScore{0.1, patched, 0.02}.explained();
    EXPECT_GE(e, before);
    EXPECT_LE(std::abs(e), 1.0);
    before = e;
  }
}

}  // namespace
}  // namespace sanso::diagnose
