// A position that is elsewhere from one row to the next cuts a recording; fast motion, glitches,
// dropouts and coarse encoders do not.
#include "tools/diagnose/gate/jumps.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_folder.h"
#include "tests/tools/diagnose/gate/made_recording.h"
#include "tools/diagnose/gate/load.h"

namespace sanso::diagnose {
namespace {

using namespace test;

const std::vector<GateJoint> kJoints{{.name = "hip"}, {.name = "knee"}};
using Rows = std::vector<std::size_t>;

/// `by` is added from `row` on.
void move(Data& d, const char* channel, std::size_t row, double by) {
  std::vector<double>& x = d[channel];
  for (std::size_t k = row; k < x.size(); ++k) x[k] += by;
}

TEST(Jumps, AJumpIsFoundWhereItIs) {
  for (const std::uint64_t seed : {3U, 4U, 5U}) {
    for (const double by : {1.1, -0.8}) {
      for (std::size_t row = 20; row < 1200; row += 59) {
        Data d = healthy(seed);
        move(d, "q:hip", row, by);
        EXPECT_EQ(position_jumps(d.view(), kJoints, {}), Rows{row}) << "seed " << seed;
      }
    }
  }
}

TEST(Jumps, ALateAndAnEarlyOneOfTwoJoints) {
  Data d = healthy();
  move(d, "q:hip", 900, 1.0);
  move(d, "q:knee", 300, -1.0);
  EXPECT_EQ(position_jumps(d.view(), kJoints, {}), (Rows{300, 900}));
}

TEST(Jumps, MotionIsNone) {
  for (const double period : {0.001, 0.0055, 0.02}) {
    for (const double quantum : {0.0, kQuantum, 0.02}) {
      const Data d = made({7, quantum, period});
      EXPECT_TRUE(position_jumps(d.view(), kJoints, {}).empty()) << period << " s, " << quantum;
    }
  }
}

/// A step of the command, a stop that is hit, and rest in between.
TEST(Jumps, StepsOfACommandAreNone) {
  Data d = healthy();
  std::vector<double>& q = d["q:hip"];
  for (std::size_t k = 0; k < q.size(); ++k) {
    const double since = d.t[k] - std::floor(d.t[k]);
    q[k] = kQuantum * std::round(std::min(0.7, 12.0 * since) / kQuantum);
    if (since > 0.5)
      q[k] = kQuantum * std::round(std::max(0.0, 0.7 - 12.0 * (since - 0.5)) / kQuantum);
  }
  EXPECT_TRUE(position_jumps(d.view(), kJoints, {}).empty());
}

TEST(Jumps, AGlitchComesBack) {
  Data d = healthy();
  d["q:hip"][400] += 2.0;
  d["q:hip"][700] -= 2.0, d["q:hip"][701] -= 2.0;
  EXPECT_TRUE(position_jumps(d.view(), kJoints, {}).empty());
}

/// Rows of a dropout repeat the last reading, then the log catches up.
TEST(Jumps, ADropoutIsNone) {
  for (std::size_t first = 50; first < 1300; first += 83) {
    Data d = healthy();
    std::vector<double>& q = d["q:hip"];
    for (std::size_t k = first; k < first + 12; ++k) q[k] = q[first];
    EXPECT_TRUE(position_jumps(d.view(), kJoints, {}).empty()) << "row " << first;
  }
}

recording::Recording recording_of(const Data& d) {
  recording::Recording r;
  r.file = "a.csv", r.t = d.t;
  for (const auto& [name, values] : d.columns) r.set(name, values);
  return r;
}

TEST(Jumps, PiecesTogetherAreTheRecording) {
  const recording::Recording whole = recording_of(healthy());
  const auto pieces = cut_at(whole, {300, 340, 900}, {});
  ASSERT_EQ(pieces.size(), 3U) << "40 rows are too few for a piece";
  std::size_t row = 0;
  for (const recording::Recording& piece : pieces) {
    if (row == 300) row = 340;
    EXPECT_EQ(piece.header_line, whole.header_line + static_cast<int>(row));
    for (std::size_t k = 0; k < piece.rows(); ++k, ++row) {
      ASSERT_EQ(piece.t[k], whole.t[row]);
      for (const char* channel : {"q:hip", "u:knee"})
        ASSERT_EQ(piece.find(channel)[k], whole.find(channel)[row]);
    }
  }
  EXPECT_EQ(row, whole.rows());
  EXPECT_EQ(cut_at(whole, {}, {}).front().file, whole.file);
}

TEST(Jumps, LoadingCutsAndSaysSo) {
  const sanso::test::TempFolder folder;
  const std::string path = (folder.path() / "bars.csv").string();
  Data d = healthy();
  move(d, "q:hip", 500, -1.12);
  std::ofstream file(path);
  file << "t";
  for (const auto& [name, values] : d.columns) file << ',' << name;
  file.precision(12);
  for (std::size_t k = 0; k < d.t.size(); ++k) {
    file << '\n' << d.t[k];
    for (const auto& [name, values] : d.columns) file << ',' << values[k];
  }
  file << '\n';
  file.close();
  const LoadedRecordings loaded = load_recordings({path}, kJoints);
  ASSERT_TRUE(loaded.gate.defects.empty()) << loaded.gate.defects.front().message;
  ASSERT_EQ(loaded.recordings.size(), 2U);
  EXPECT_EQ(loaded.recordings[0].rows(), 500U);
  ASSERT_FALSE(loaded.gate.notes.empty());
  EXPECT_NE(loaded.gate.notes.back().find("cut there"), std::string::npos);
}

}  // namespace
}  // namespace sanso::diagnose
