// Rows that were written again are told from a robot that rests, sticks or moves slowly.
#include "tools/diagnose/gate/stale.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/diagnose/gate/made_recording.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Whether a cycle is lost, by row, in runs of three on the mean: `share` of all.
std::vector<char> bursts(std::size_t rows, double share) {
  Random random(11);
  std::vector<char> out(rows, 0);
  for (std::size_t k = 2; k + 2 < rows; ++k) {
    const double begins = share / (3.0 * (1.0 - share));
    out[k] = random.uniform() < (out[k - 1] != 0 ? 2.0 / 3.0 : begins) ? 1 : 0;
  }
  return out;
}

/// Nothing new is read in these rows.
Data lossy(Data d, const std::vector<char>& lost) {
  for (auto& [name, x] : d.columns) {
    if (name[0] == 'u') continue;
    for (std::size_t k = 1; k < x.size(); ++k)
      if (lost[k] != 0) x[k] = x[k - 1];
  }
  return d;
}

TEST(Stale, RowsThatWereWrittenAgainAreFound) {
  for (const double quantum : {0.0, kQuantum}) {
    const Data whole = made({3, quantum});
    for (const double share : {0.05, 0.3}) {
      const std::vector<char> lost = bursts(whole.t.size(), share),
                              found = stale_rows(lossy(whole, lost).view(), {});
      ASSERT_EQ(found.size(), lost.size()) << share;
      int right = 0, all = 0, wrong = 0;
      for (std::size_t k = 0; k < lost.size(); ++k) {
        all += lost[k], right += lost[k] != 0 && found[k] != 0 ? 1 : 0;
        wrong += lost[k] == 0 && found[k] != 0 ? 1 : 0;
      }
      EXPECT_GT(right, 0.95 * all) << share;
      EXPECT_LT(wrong, 0.01 * all + 2) << share;
    }
  }
}

TEST(Stale, AHealthyRecordingHasNone) {
  for (const double quantum : {0.0, kQuantum})
    EXPECT_TRUE(stale_rows(made({3, quantum}).view(), {}).empty()) << quantum;
}

// At rest every reading repeats, and a joint that breaks away moves slowly at first.
TEST(Stale, AJointThatSticksAndSlipsHasNone) {
  Data d;
  for (int k = 0; k < 4000; ++k) d.t.push_back(0.01 * k);
  double speed = 0.0, place = 0.0;
  for (std::size_t k = 0; k < d.t.size(); ++k) {
    const bool slips = k % 40 >= 25;
    speed =
        slips ? speed + 0.02 * std::cos(3.14159 * static_cast<double>(k % 40 - 25) / 14.0) : 0.0;
    place += 0.01 * speed;
    d["q:a"][k] = place;
    d["dq:a"][k] = speed;
  }
  EXPECT_TRUE(stale_rows(d.view(), {}).empty());
}

TEST(Stale, CoarseCountsOfASlowMotionAreNone) {
  Data d;
  Random random(4);
  for (int k = 0; k < 4000; ++k) d.t.push_back(0.01 * k);
  for (std::size_t k = 0; k < d.t.size(); ++k) {
    d["q:a"][k] = kQuantum * std::round(0.1 * static_cast<double>(k) + 0.4 * random.normal());
    d["dq:a"][k] = 0.1 * std::round(0.5 * random.normal());
  }
  EXPECT_TRUE(stale_rows(d.view(), {}).empty());
}

TEST(Stale, APositionAloneIsNoProof) {
  Data d = lossy(made({3, 0.0}), bursts(made({3, 0.0}).t.size(), 0.3)), alone;
  alone.t = d.t;
  alone["q:hip"] = d["q:hip"];
  EXPECT_TRUE(stale_rows(alone.view(), {}).empty());
}

TEST(Stale, TheGateTellsHowMany) {
  const Data whole = healthy();
  const GateReport report = inspect({lossy(whole, bursts(whole.t.size(), 0.2)).view()}, joints());
  EXPECT_FALSE(report.refused());
  EXPECT_THAT(report.notes, testing::Contains(testing::HasSubstr("repeat all readings")));
}

}  // namespace
}  // namespace sanso::diagnose
