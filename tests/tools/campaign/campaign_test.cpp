// The fault campaign: its list is the product it claims to be, its judge sees each kind of defect,
// and the rows that once failed run here too.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tools/campaign/campaign.h"
#include "tools/campaign/falls.h"
#include "tools/campaign/run_scenario.h"
#include "tools/campaign/soak.h"

namespace sanso::campaign {
namespace {

using firmware::Fault;

Scenario find(const std::string& name) {
  for (const Scenario& scenario : scenarios())
    if (scenario.name() == name) return scenario;
  throw std::invalid_argument("no scenario " + name);
}

TEST(Campaign, EveryCellRunsInEveryMotionUnderANameOfItsOwn) {
  std::set<std::string> names;
  std::set<int> words, directions;
  for (const Scenario& s : scenarios()) {
    EXPECT_TRUE(names.insert(s.name()).second) << s.name();
    words.insert(static_cast<int>(s.word));
    directions.insert(static_cast<int>(s.direction));
    EXPECT_FALSE(s.expected.endings.empty()) << s.name();
    EXPECT_TRUE(s.trouble.fault.has_value() != (s.trouble.act != Act::none)) << s.name();
  }
  const std::size_t arming = arming_scenarios().size();
  EXPECT_EQ(arming, 2u * 11u + 4u * 24u);
  EXPECT_EQ(names.size(), cells().size() * kMotions.size() + arming);
  EXPECT_GE(names.size(), 60u);
  EXPECT_EQ(words.size(), 7u) << "each word occurs";
  EXPECT_EQ(directions.size(), 3u);
}

TEST(Falls, APushOverEndsLimpAndNoPushIsNoFall) {
  FallOptions options;
  options.push_N = 0.0;
  EXPECT_FALSE(fall(options, 0.0, 0.2).fell);
  options.push_N = 80.0;
  const Fall over = fall(options, 1.5, 0.2);
  EXPECT_TRUE(over.fell);
  EXPECT_GT(over.speed_m_s, 0.1);
  EXPECT_GE(over.released_s, 0.0) << "torque goes after a fall";
}

TEST(Campaign, TheJudgeSeesEachDefect) {
  const Expected expected{{Fault::imu_silent}, {Ending::lowered}, 0.08, false, 0};
  Found good;
  good.fault = Fault::imu_silent;
  good.reaction_s = 0.07;
  good.ending = Ending::lowered;
  good.step_rad = 0.15;
  EXPECT_TRUE(broken_of(expected, good, "").empty());
  const auto defects = [&](auto&& spoil) {
    Found found = good;
    spoil(found);
    return broken_of(expected, found, "").size();
  };
  EXPECT_EQ(defects([](Found& f) { f.fault = Fault::imu_frozen; }), 1u);
  EXPECT_EQ(defects([](Found& f) { f.fault = Fault::none; }), 1u);
  EXPECT_EQ(defects([](Found& f) { f.reaction_s = 0.09; }), 1u);
  EXPECT_EQ(defects([](Found& f) { f.ending = Ending::limp; }), 1u);
  EXPECT_EQ(defects([](Found& f) { f.step_rad = 0.16; }), 1u);
  EXPECT_EQ(defects([](Found& f) { f.fell = true, f.torque_Nm = 0.0; }), 1u);
  EXPECT_EQ(defects([](Found& f) { f.fell = true, f.torque_Nm = 0.1; }), 2u);
  const Expected nothing{{}, {Ending::completes}, 0, false, 0};
  Found calm;
  EXPECT_TRUE(broken_of(nothing, calm, "").empty());
  EXPECT_EQ(broken_of(nothing, calm, "tilt").size(), 1u);
  calm.fault = Fault::imu_silent;
  EXPECT_EQ(broken_of(nothing, calm, "").size(), 1u);
}

TEST(Campaign, ARefusalNeedsANumberAndArmingACalmRobot) {
  const Expected arming{{}, {Ending::completes, Ending::refused}, 0, false, 1.5};
  Found refused;
  refused.ending = Ending::refused;
  EXPECT_EQ(broken_of(arming, refused, "").size(), 1u);
  refused.refusal = 109;
  EXPECT_TRUE(broken_of(arming, refused, "").empty());
  Found whipped;
  whipped.speed_rad_s = 1.6;
  EXPECT_EQ(broken_of(arming, whipped, "").size(), 1u);
  // of a turned sensor: refused, or the fault and down; nothing else
  const Expected turned{
      {Fault::imu_implausible}, {Ending::refused, Ending::lowered}, 1e3, false, 0};
  EXPECT_TRUE(broken_of(turned, refused, "not armed").empty());
  EXPECT_FALSE(broken_of(turned, Found{}, "").empty());
}

TEST(Campaign, TheWrongMountingsAreTheOthersOfTwentyFour) {
  std::set<std::array<double, 4>> quats;
  for (const Cell& cell : cells())
    if (cell.trouble.act == Act::turn_imu) quats.insert(cell.trouble.quat_base_sensor);
  EXPECT_EQ(quats.size(), 23u);
  EXPECT_EQ(quats.count({1, 0, 0, 0}), 0u);
}

class Rows : public testing::TestWithParam<const char*> {};

TEST_P(Rows, AreAsExpected) {
  const Found found = run_scenario(find(GetParam()), 1);
  for (const std::string& what : found.broken) ADD_FAILURE() << what;
  EXPECT_EQ(found.ticks_lost, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Each, Rows,
    testing::Values("stand/servo_14/wrong/reply/zeros_for_ever",
                    "squat/servo_14/wrong/reply/zeros_for_5_ticks",
                    "squat/bus/intermittent/request/lost", "walk_forward/bus/delayed/reply/20_ms",
                    "walk_forward/bus/intermittent/reply/lost",
                    "walk_forward/person/off/emergency_stop", "squat/imu/wrong/mounted_-x_-y_+z",
                    "walk_forward/imu/wrong/mounted_+y_-x_+z",
                    "arming/host/slow/0_ticks_after_idle", "arming/bus/off/request/packet_2_lost"),
    [](const auto& p) {
      std::string name = p.param;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
      return name;
    });

TEST(Soak, AFewRoundsOfAnythingBreakNoLaw) { EXPECT_EQ(bench_soak({12'000, 1, "lab", false}), 0); }

TEST(Soak, ARobotOnAStandBreaksNoLawEither) {
  EXPECT_EQ(bench_soak({60'000, 2, "hung", false}), 0);
}

TEST(Campaign, ThePageAndTheJsonHaveARowForEachScenario) {
  std::vector<Row> rows{{find("stand/imu/off"), {}}, {find("squat/imu/stuck"), {}}};
  rows[1].found.broken.push_back("falls");
  const std::string page = page_of(rows, {});
  EXPECT_NE(page.find("2 rows, 1 not as expected"), std::string::npos);
  EXPECT_NE(page.find("| squat | imu | stuck |"), std::string::npos);
  EXPECT_NE(page.find("**no**: falls"), std::string::npos);
  EXPECT_NE(json_of(rows, {}).find("\"name\": \"stand/imu/off\""), std::string::npos);
}

}  // namespace
}  // namespace sanso::campaign
