// Events over all of the recorded time: none that matter in a robot within its tolerances, those of
// a push that comes twice, and what a tolerated model scatters never makes an event.
#include "tools/diagnose/explain/whole_time.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/explain/rivals.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kPush = 4.26;  // s

ModelFolder rubbing() { return pendulum(std::string(kNoisyServo) + "coulomb = 0.03\n"); }

/// One recording of 8 s of every world.
std::vector<Source> sources(const std::vector<ModelFolder>& worlds) {
  std::vector<recording::Recording> made;
  for (std::size_t k = 0; k < worlds.size(); ++k) {
    const int index = static_cast<int>(k);
    const Drive drive = make_test_drive(worlds[k], 8.0, 0.01,
                                        [index](int j, double t) { return wave(index, j, t); });
    made.push_back(record(worlds[k], drive,
                          {.file = "rec_" + std::to_string(k) + ".csv", .noise_seed = 700 + k}));
  }
  return make_sources(rubbing(), made, noise_of(rubbing()), Settings{});
}

WholeTime whole(const std::vector<ModelFolder>& worlds, const ProblemOptions& search = {}) {
  return WholeTime(sources(worlds), noise_of(rubbing()), search, Settings{});
}

ModelFolder pushed() {
  return hiding(rubbing(), {hidden("external_push", "arm",
                                   {{"x", 6.0}, {"from", kPush}, {"duration", 0.12}})});
}

/// Heavier, stiffer and rubbing otherwise than it says, by less than the tolerances.
ModelFolder tolerated(double sign) {
  ModelFolder world = rubbing();
  world.tree.joints[0].body.mass *= 1.0 + sign * 0.02;
  world.joints[0].coulomb *= 1.0 + sign * 0.04;
  world.joints[0].resistance *= 1.0 - sign * 0.015;
  return world;
}

TEST(WholeTime, ARobotWithinItsTolerancesHasNoEventsThatMatter) {
  for (const double sign : {0.0, 1.0, -1.0}) {
    const WholeTime w = whole({tolerated(sign), tolerated(sign)});
    EXPECT_FALSE(w.nominal_matters()) << sign;
    EXPECT_LE(w.nominal().events.size(), 1U) << sign;
  }
}

TEST(WholeTime, APushThatComesTwiceMattersAndIsFoundWhereItWas) {
  const WholeTime w = whole({pushed(), pushed()});
  EXPECT_TRUE(w.nominal_matters());
  ASSERT_GE(w.nominal().events.size(), 2U);
  const ProblemOptions options = w.with_instants({});
  ASSERT_FALSE(options.instants.empty());
  EXPECT_LE(options.instants.front(), kPush + 0.12);
  EXPECT_GT(options.instants.front(), kPush - 0.5);
  EXPECT_EQ(options.struck.size(), w.nominal().events.size());
  for (const std::size_t joint : options.struck) EXPECT_EQ(joint, 0U);
  std::map<std::size_t, int> by_recording;
  for (const Event& e : w.nominal().events) ++by_recording[w.comparison().shots[e.shot].source];
  EXPECT_EQ(by_recording.size(), 2U) << "in either recording";
  for (std::size_t k = 1; k < w.nominal().events.size(); ++k)
    EXPECT_GE(w.nominal().events[k - 1].excess, w.nominal().events[k].excess);
}

TEST(WholeTime, APushInOneShotOfOneRecordingIsAnAccident) {
  const WholeTime w = whole({pushed(), rubbing(), rubbing()});
  ASSERT_FALSE(w.nominal().events.empty());
  for (const Event& e : w.nominal().events) EXPECT_EQ(w.comparison().shots[e.shot].source, 0U);
  std::vector<Event> once(w.nominal().events.begin(), w.nominal().events.begin() + 1);
  EXPECT_EQ(repeated(once).energy, 0.0);
}

TEST(WholeTime, AModelThatKnowsThePushLeavesNone) {
  const WholeTime w = whole({pushed(), pushed()});
  const Problem instants = make_problem(sources({pushed(), pushed()}), noise_of(rubbing()),
                                        w.with_instants({}), Settings{});
  Library library;
  library.candidates = place_library(*instants, {"external_push"}).candidates;
  library.nuisances = make_nuisances(w.comparison());
  ASSERT_EQ(library.candidates.size(), 1U);
  const EventsLeft left = w.left_by(library, Model{{{0, {6.0, 0.0, 0.0, kPush, 0.12}}}, {}});
  EXPECT_TRUE(left.events.empty());
  EXPECT_LT(left.energy, 0.5 * w.nominal().energy);
  // what is left is noise: less than one a row, since starts take some out
  EXPECT_NEAR(left.energy / static_cast<double>(w.comparison().size), 0.95, 0.15);
  const EventsLeft nothing = w.left_by(library, Model{});
  EXPECT_EQ(nothing.energy, w.nominal().energy);
}

TEST(WholeTime, LeavesNoShotOutAndLooksAtPositionsOnly) {
  ProblemOptions search;
  search.maximum_shots = 4;
  const WholeTime w = whole({rubbing(), rubbing()}, search);
  EXPECT_EQ(w.comparison().shots.size(), 2U * 16U);
  for (const Observed& channel : w.comparison().channels) EXPECT_EQ(channel.signal, Signal::q);
  EXPECT_EQ(w.with_instants(search).maximum_shots, 4) << "the search's own thinning stays";
}

TEST(ToleratedScatter, OnlyRaisesTheLevel) {
  const Problem problem =
      make_problem(sources({rubbing(), rubbing()}), noise_of(rubbing()), {}, Settings{});
  Random random(31);
  Eigen::VectorXd error(static_cast<Eigen::Index>(problem->size));
  for (double& e : error) e = random.normal();
  for (std::size_t s = 0; s < problem->shots.size(); s += 6)
    rows_of(error, problem->shots[s], 0) *= 5.0 + static_cast<double>(s);
  const std::vector<Event> all = find_events(problem, error);
  ASSERT_GE(all.size(), 4U);
  for (const double level : {0.0, 0.5, 2.0, 20.0, 200.0}) {
    Eigen::MatrixXd usual =
        Eigen::MatrixXd::Zero(1, static_cast<Eigen::Index>(problem->shots.size()));
    for (Eigen::Index s = 0; s < usual.cols(); ++s) usual(0, s) = level * random.uniform();
    const std::vector<Event> fewer = find_events(problem, error, usual);
    EXPECT_LE(fewer.size(), all.size());
    for (const Event& e : fewer) {
      const auto was =
          std::find_if(all.begin(), all.end(), [&](const Event& x) { return x.shot == e.shot; });
      ASSERT_NE(was, all.end()) << "scatter made an event of shot " << e.shot;
      EXPECT_LE(e.excess, was->excess);
      EXPECT_EQ(e.level, was->level);
    }
    if (level <= 0.5) {
      EXPECT_EQ(fewer.size(), all.size()) << "less than noise raises nothing";
    }
  }
}

}  // namespace
}  // namespace sanso::diagnose
