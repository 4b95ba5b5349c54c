// Errors that stand alone: what counts as one, what repeats, and what the search is given of them.
#include "tools/diagnose/explain/events.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/support/small_world.h"
#include "tools/diagnose/compare/candidate.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kServo =
    "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\nposition_noise = 3e-4\n";
const std::vector<NoiseLevel> kNoise{{"q:a", 0.0, 3e-4, {}}};

std::vector<Source> sources(int recordings) {
  std::vector<recording::Recording> made;
  for (int i = 0; i < recordings; ++i) {
    const Drive drive = test::make_test_drive(
        test::pendulum(kServo), 10.0, 0.01, [i](int, double t) { return std::sin((1.0 + i) * t); });
    recording::Recording r;
    r.file = "made_" + std::to_string(i) + ".csv";
    r.t = drive.t;
    r.set("u:a", drive.joints[0].command);
    r.set("q:a", drive.joints[0].command);
    made.push_back(r);
  }
  return make_sources(test::pendulum(kServo), made, kNoise, Settings{});
}

/// Noise of one level everywhere, and `level` times it in some shots.
Eigen::VectorXd errors(const Problem& problem, const std::vector<std::size_t>& shots,
                       double level) {
  Eigen::VectorXd r(static_cast<Eigen::Index>(problem->size));
  for (Eigen::Index i = 0; i < r.size(); ++i) r[i] = i % 2 == 0 ? 1.0 : -1.0;
  for (const std::size_t s : shots) {
    rows_of(r, problem->shots[s], 0) *= level;
  }
  return r;
}

TEST(Events, AreFarAboveNoiseAndAboveTheOtherShots) {
  const Problem problem = make_problem(sources(2), kNoise, ProblemOptions{}, Settings{});
  EXPECT_TRUE(find_events(problem, errors(problem, {}, 1.0)).empty());
  EXPECT_TRUE(find_events(problem, errors(problem, {3, 5}, 2.5)).empty());
  const std::vector<Event> events = find_events(problem, errors(problem, {3, 25}, 10.0));
  ASSERT_EQ(events.size(), 2U);
  EXPECT_NEAR(events[0].level, 10.0, 1e-9);
  EXPECT_NEAR(events[0].excess, 99.0 * static_cast<double>(problem->shots[3].rows), 1e-6);
  // a model that is wrong everywhere has no events
  EXPECT_TRUE(find_events(problem, 10.0 * errors(problem, {}, 1.0)).empty());
}

TEST(Events, WhatAToleratedModelScattersIsNone) {
  const Problem problem = make_problem(sources(2), kNoise, ProblemOptions{}, Settings{});
  const Eigen::VectorXd error = errors(problem, {3, 25}, 10.0);
  EXPECT_NEAR(mean_squares(problem, error)(0, 25), 100.0, 1e-9);
  Eigen::MatrixXd tolerated = Eigen::MatrixXd::Zero(mean_squares(problem, error).rows(),
                                                    mean_squares(problem, error).cols());
  tolerated(0, 3) = 20.0;
  const std::vector<Event> events = find_events(problem, error, tolerated);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].shot, 25U);
}

TEST(Events, WhatHappensOnceIsAnAccident) {
  const Problem problem = make_problem(sources(2), kNoise, ProblemOptions{}, Settings{});
  EXPECT_FALSE(repeated({}).joint);
  EXPECT_EQ(repeated(find_events(problem, errors(problem, {7}, 30.0))).energy, 0.0);
  const RepeatedEvents twice = repeated(find_events(problem, errors(problem, {7, 27}, 30.0)));
  EXPECT_EQ(twice.joint, std::size_t{0});
  EXPECT_NEAR(twice.energy, 899.0 * static_cast<double>(problem->shots[7].rows), 1e-6);
}

TEST(Events, ThinningKeepsTheirShotsAndNeighboursInEveryRecording) {
  const Problem all = make_problem(sources(3), kNoise, ProblemOptions{}, Settings{});
  // 4.5 s into two recordings
  const std::vector<Event> events = find_events(all, errors(all, {9, 29}, 10.0));
  ProblemOptions options;
  options.maximum_shots = 6;
  options.instants = instants_of(*all, events, 4);
  ASSERT_EQ(options.instants.size(), 1U);  // the same instant of both
  EXPECT_NEAR(options.instants[0], 4.5, 1e-9);
  const Problem thin = make_problem(sources(3), kNoise, options, Settings{});
  std::vector<std::set<int>> tenths(3);
  for (const Shot& s : thin->shots) {
    tenths[s.source].insert(
        static_cast<int>(std::lround(10 * thin->sources[s.source].drive.t[s.window.first])));
  }
  for (const std::set<int>& have : tenths) {
    for (const int from : {40, 45, 50}) EXPECT_TRUE(have.contains(from)) << from;
  }
  EXPECT_LE(thin->shots.size(), 6U + 9U);
}

TEST(Events, APushIsPlacedOnlyWhereErrorsStandAlone) {
  ProblemOptions options;
  EXPECT_TRUE(
      place_library(*make_problem(sources(2), kNoise, options, Settings{}), {"external_push"})
          .candidates.empty());
  options.instants = {4.5};
  EXPECT_TRUE(
      place_library(*make_problem(sources(2), kNoise, options, Settings{}), {"external_push"})
          .candidates.empty());
  options.struck = {0};
  const Placement placed =
      place_library(*make_problem(sources(2), kNoise, options, Settings{}), {"external_push"});
  ASSERT_EQ(placed.candidates.size(), 1U);
  for (const std::vector<double>& probe : placed.candidates[0].probes) {
    EXPECT_GE(probe[3], 4.5);
    EXPECT_LT(probe[3], 5.0);
  }
}

}  // namespace
}  // namespace sanso::diagnose
