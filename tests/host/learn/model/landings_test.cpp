// Recordings end for learning where a flight lands.
#include "host/learn/model/landings.h"

#include <gtest/gtest.h>

#include "tests/host/learn/model/learner_world.h"

namespace sanso::learn {
namespace {

constexpr int kFlight = 3;
constexpr std::uint8_t kBothFeet = 3;

/// A trial in whose ticks [from, to) no foot is loaded.
Episode flies(int from, int to) {
  Episode e = episode_of_world(1);
  for (std::size_t i = 0; i < e.ticks.size(); ++i) {
    const int tick = static_cast<int>(i);
    e.ticks[i].tick = 1000 + i;
    e.ticks[i].contact = tick >= from && tick < to ? 0 : kBothFeet;
  }
  return e;
}

std::vector<int> left_out(const Episode& e, int flight_ticks) {
  std::vector<int> gone;
  const std::vector<wire::Observation> kept = without_landings(e.ticks, flight_ticks);
  auto next = kept.begin();
  for (const wire::Observation& o : e.ticks)
    if (next != kept.end() && next->trial_tick == o.trial_tick)
      ++next;
    else
      gone.push_back(o.trial_tick);
  return gone;
}

TEST(Landings, LastUntilAFootHasBeenLoadedForAsLongAsAFlight) {
  EXPECT_EQ(left_out(flies(100, 103), kFlight), (std::vector<int>{103, 104, 105}));
  EXPECT_TRUE(left_out(flies(100, 102), kFlight).empty()) << "a tick less is no flight";
  EXPECT_TRUE(left_out(flies(kTicks - 20, kTicks), kFlight).empty()) << "it never landed";
  EXPECT_TRUE(left_out(flies(100, 120), 0).empty()) << "switched off";
  Episode bounces = flies(100, 120);
  bounces.ticks[122].contact = 0;
  EXPECT_EQ(left_out(bounces, kFlight), (std::vector<int>{120, 121, 122, 123, 124, 125}));
  Episode flickers = flies(100, 120);
  flickers.ticks[118].contact = 1;  // one foot is enough to end a flight
  EXPECT_EQ(left_out(flickers, kFlight), (std::vector<int>{118, 119, 120, 121, 122}));
}

TEST(Landings, NoWindowHoldsOneAndBothSidesAreLearnedFrom) {
  constexpr int kLands = 130;
  const Episode e = flies(117, kLands);
  const ModelLearner learner({}, weights(), {}, kSeed);
  int before = 0, behind = 0;
  for (const PredictionWindow& w : learner.learning_windows(e)) {
    int first = -1;
    for (const wire::Observation& o : e.ticks)
      if (o.x == w.x[0]) first = o.trial_tick;
    ASSERT_GE(first, 0);
    const int last = first + w.steps * kTicksPerStep;
    EXPECT_TRUE(last < kLands || first > kLands) << first << " to " << last;
    if (w.steps == kPredictionSteps) ++(last < kLands ? before : behind);
  }
  EXPECT_GT(before, 5);
  EXPECT_GT(behind, 5);
}

/// Walks and all else that does not fly: the very windows.
TEST(Landings, AMotionWithoutFlightIsLearnedFromAsItWas) {
  const ModelLearner learner({}, weights(), {}, kSeed);
  const Episode e = flies(0, 0);
  const auto windows = learner.learning_windows(e), usable = learner.usable_windows(e);
  ASSERT_EQ(windows.size(), usable.size());
  for (std::size_t i = 0; i < windows.size(); ++i) EXPECT_TRUE(windows[i].x[0] == usable[i].x[0]);
}

/// What follows a landing is a fall or none. A model that is learned from it says less of the rest.
TEST(Landings, WhatFollowsOneDoesNotBendTheModel) {
  constexpr int kLands = 200;
  const auto loss_of_flights = [](int flight_ticks) {
    ModelLearningSettings settings;
    settings.identify.search.generations = 3;
    settings.use_residual = false;
    settings.flight_ticks = flight_ticks;
    ModelLearner learner({}, weights(), settings, kSeed);
    std::vector<Episode> trials;
    for (std::uint32_t t = 0; t < 4; ++t) {
      Episode e = episode_of_world(t);
      const Episode other = episode_of_world(t + 100);
      for (std::size_t i = 0; i < e.ticks.size(); ++i) {
        // lands elsewhere and goes on as the same robot
        if (i >= kLands) {
          e.ticks[i] = other.ticks[i];
          e.ticks[i].x[0] += 0.3;
        }
        e.ticks[i].tick = 1000 + i;
        e.ticks[i].contact = i >= kLands - 10 && i < kLands ? 0 : kBothFeet;
      }
      trials.push_back(e);
    }
    learner.learn(trials);
    return learner.losses(episode_of_world(50))->analytical;
  };
  EXPECT_LT(loss_of_flights(kFlight), 0.5 * loss_of_flights(0));
}

}  // namespace
}  // namespace sanso::learn
