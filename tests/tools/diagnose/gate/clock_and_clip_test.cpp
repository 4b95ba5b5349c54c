// Columns whose clocks differ and commands that the log cuts off are refused; servos that are slow,
// early or asked for flat tops are not.
#include <gtest/gtest.h>

#include "tests/tools/diagnose/gate/made_recording.h"
#include "tools/diagnose/gate/checks.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// The column as it would be read `rows` later (earlier, when negative).
void shift(std::vector<double>& x, long rows) {
  const std::vector<double> was = x;
  const auto last = static_cast<long>(x.size()) - 1;
  for (long k = 0; k <= last; ++k)
    x[static_cast<std::size_t>(k)] = was[static_cast<std::size_t>(std::clamp(k - rows, 0L, last))];
}

Making long_one(std::uint64_t seed) {
  Making how;
  how.seed = seed;
  how.seconds = 20.0;
  return how;
}

TEST(Clocks, AnAnswerBeforeTheCommandIsRefused) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Data d = made(long_one(seed));
    std::erase_if(d.columns, [](const auto& c) { return c.first.rfind("dq:", 0) == 0; });
    ASSERT_EQ(first_defect(d).defect, "") << seed;
    shift(d["q:knee"], -70);  // 0.39 s, of which the servo's own lag eats some
    const Defect found = first_defect(d);
    EXPECT_EQ(found.defect, defect::kShiftedClock) << seed;
    EXPECT_EQ(found.channel, "q:knee");
    EXPECT_NE(found.message.find("u:knee"), std::string::npos) << found.message;
  }
}

TEST(Clocks, ACommandThatActsLateIsAnEffectAndPasses) {
  Data d = made(long_one(4));
  std::erase_if(d.columns, [](const auto& c) { return c.first.rfind("pwm:", 0) == 0; });
  for (const char* column : {"q:knee", "dq:knee"}) shift(d[column], 20);
  EXPECT_EQ(first_defect(d).defect, "");
}

TEST(Clocks, AVelocityOfAnotherTimeIsRefusedAndAFilteredOneIsNot) {
  for (const long rows : {-40L, 40L, 9L, 0L}) {
    Data d = made(long_one(5));
    shift(d["dq:hip"], rows);  // 9 rows: 50 ms, the slowest register that is known
    const Defect found = first_defect(d);
    const bool refused = rows == 40 || rows == -40;
    EXPECT_EQ(found.defect, refused ? defect::kShiftedClock : "") << rows << ": " << found.message;
    EXPECT_EQ(found.channel, refused ? "dq:hip" : "");
  }
}

TEST(Clocks, OneSensorHasOneDelayInAllRecordings) {
  std::vector<Data> files;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    files.push_back(made(long_one(seed)));
    files.back().file = std::to_string(seed) + ".csv";
    shift(files.back()["dq:hip"], 4);
  }
  const auto report = [&] {
    return inspect({files[0].view(), files[1].view(), files[2].view(), files[3].view()}, joints());
  };
  EXPECT_FALSE(report().refused());
  shift(files[2]["dq:hip"], 12);  // 66 ms, and 88 in all: by itself no more than a filter
  const GateReport found = report();
  ASSERT_EQ(found.defects.size(), 1U);
  EXPECT_EQ(found.defects[0].defect, defect::kShiftedClock);
  EXPECT_EQ(found.defects[0].file, "3.csv");
  EXPECT_EQ(found.defects[0].channel, "dq:hip");
}

TEST(ClippedCommand, IsRefusedWhereTheJointGoesOnBeyondIt) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Data d = made(long_one(seed));
    for (double& u : d["u:hip"]) u = std::clamp(u, -0.4, 0.4);
    const Defect found = first_defect(d);
    EXPECT_EQ(found.defect, defect::kClipped) << seed;
    EXPECT_EQ(found.channel, "u:hip");
    ASSERT_GE(found.row, 1);
    const auto row = static_cast<std::size_t>(found.row);
    EXPECT_EQ(std::abs(d["u:hip"][row]), 0.4);
    EXPECT_NE(d["u:hip"][row - 1], d["u:hip"][row]) << "the first row of a flat top";
  }
}

TEST(ClippedCommand, FlatTopsThatTheServoWasAskedForPass) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Making how = long_one(seed);
    how.largest_command = 0.4;
    EXPECT_EQ(first_defect(made(how)).defect, "") << seed;
  }
}

TEST(ClippedCommand, BeyondTheJointsLimitIsSaidAndNotRefused) {
  const auto notes = [](double lower, double upper) {
    Data d = made(long_one(2));
    for (double& q : d["q:hip"]) q = std::clamp(q, lower + 0.003, upper - 0.003);
    std::erase_if(d.columns, [](const auto& c) { return c.first == "dq:hip"; });
    return gate::unfollowed_commands(d.view(), {{"hip", false, lower, upper}});
  };
  const std::vector<std::string> said = notes(-1.0, 0.3);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("u:hip asks for 0.6"), std::string::npos) << said[0];
  EXPECT_TRUE(notes(-1.0, 1.0).empty());
}

}  // namespace
}  // namespace sanso::diagnose
