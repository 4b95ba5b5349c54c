// When recordings disagree about a size, and when chance or one robot on two days does.
#include "tools/diagnose/torque/disagreement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/tools/diagnose/torque/written_effort.h"
#include "tools/diagnose/torque/judge.h"

namespace sanso::diagnose {
namespace {

std::string said(const std::vector<GroupValue>& values) {
  return disagreement("friction", "N m", values, DecisionSettings{});
}

TEST(Disagreement, OneFarFromTheOthersIsSaidWithAllValues) {
  const std::string text = said({{"one", 0.2, 0.01}, {"two", 0.21, 0.01}, {"three", 0.5, 0.02}});
  for (const char* part : {"friction", "one", "two", "three", "0.5", "N m"})
    EXPECT_NE(text.find(part), std::string::npos) << part << ": " << text;
}

TEST(Disagreement, ChanceAndSmallDifferencesAreNone) {
  EXPECT_EQ(said({{"one", 0.2, 0.1}, {"two", 0.5, 0.1}}), "") << "within chance";
  EXPECT_EQ(said({{"one", 0.2, 1e-4}, {"two", 0.22, 1e-4}}), "") << "a tenth of its size";
  EXPECT_EQ(said({{"one", 0.2, 0.01}}), "") << "nobody to disagree with";
  EXPECT_EQ(said({{"one", 0.2, 0.01}, {"two", 9.0, NAN}, {"three", 9.0, 0.0}}), "")
      << "two that do not tell it";
}

TEST(Disagreement, DoesNotDependOnTheOrderOrTheUnit) {
  const std::vector<GroupValue> values{{"a", 1.0, 0.05}, {"b", 2.0, 0.05}, {"c", 1.0, 0.05}};
  for (const double scale : {1e-6, 1.0, 1e6}) {
    std::vector<GroupValue> other(values.rbegin(), values.rend());
    for (GroupValue& v : other) v.value *= scale, v.sigma *= scale;
    EXPECT_FALSE(said(other).empty()) << scale;
  }
}

bool disagrees(double second) {
  using namespace test;
  std::vector<EffortRecording> both;
  const ModelFolder model = two_links("actuator = \"torque\"\ntorque_limit = 0.0\n");
  for (const char* file : {"one.csv", "two.csv"})
    both.push_back(recorded(model, file, 15.0, sines));
  const double at_once[] = {0.2, second};
  int row = 0;
  const int half = static_cast<int>(both.front().t.size()) * 2;
  const EffortRows rows = rows_of(both, [&](const MotionSample& m, int j, double) {
    const int recording = row++ < half ? 0 : 1;
    return j == 0 ? at_once[recording] * sign(m.dq[0]) : 0.0;
  });
  const EffortOutcome outcome = explain_effort(rows, Settings{}, {});
  return std::any_of(outcome.notes.begin(), outcome.notes.end(), [](const std::string& note) {
    return note.starts_with("recordings disagree about coulomb_friction at a");
  });
}

TEST(Disagreement, OfTwoRecordingsIsNotedOnTheTorqueSide) {
  EXPECT_TRUE(disagrees(0.5));
  EXPECT_FALSE(disagrees(0.2));
}

}  // namespace
}  // namespace sanso::diagnose
