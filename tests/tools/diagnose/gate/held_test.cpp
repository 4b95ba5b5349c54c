// Channels that are refreshed every n rows are told from those that move slowly.
#include "tools/diagnose/gate/held.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_folder.h"
#include "tests/tools/diagnose/gate/made_recording.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/recording/mcap_recording.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// x as a register shows it that is refreshed every `rows`, first at row `phase`.
std::vector<double> held(std::vector<double> x, std::size_t rows, std::size_t phase) {
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = x[k < phase ? 0 : k - (k - phase) % rows];
  return x;
}

TEST(Held, RowsBetweenRefreshesAreCounted) {
  for (const double quantum : {0.0, kQuantum}) {
    for (const std::size_t rows : {1U, 2U, 3U, 7U, 15U}) {
      Data d = made({3, quantum});
      EXPECT_EQ(rows_between_refreshes(held(d["q:hip"], rows, 4), {}), static_cast<int>(rows))
          << rows << " rows, quantum " << quantum;
    }
  }
}

TEST(Held, AClockOfItsOwnBeatsWithTheRows) {
  Data d = made({3, kQuantum});
  std::vector<double> x = d["q:hip"];
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double refresh = std::floor(static_cast<double>(k) / 6.3) * 6.3;
    x[k] = d["q:hip"][static_cast<std::size_t>(std::ceil(refresh))];
  }
  EXPECT_EQ(rows_between_refreshes(x, {}), 6);
}

TEST(Held, SlowMotionOfACoarseEncoderIsNot) {
  std::vector<double> ramp, noisy;
  Random random(5);
  for (int k = 0; k < 4000; ++k) {
    ramp.push_back(kQuantum * std::round(0.2 * k));  // one count every five rows
    noisy.push_back(kQuantum * std::round(0.05 * k + 0.3 * random.normal()));
  }
  EXPECT_EQ(rows_between_refreshes(ramp, {}), 1);
  EXPECT_EQ(rows_between_refreshes(noisy, {}), 1);
  EXPECT_EQ(rows_between_refreshes(std::vector<double>(4000, 0.2), {}), 1);
}

TEST(Held, OneRowOfEachRefreshIsKeptAndNoneIsMadeUp) {
  Data d = made({3, kQuantum});
  const std::vector<double> x = held(d["q:hip"], 7, 3), kept = one_row_per_refresh(x, 7);
  std::size_t rows = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    EXPECT_TRUE(k == 0 || x[k] == x[k - 1] || kept[k] == x[k]) << "a refresh at row " << k;
    if (std::isnan(kept[k])) continue;
    EXPECT_EQ(kept[k], x[k]);
    ++rows;
  }
  EXPECT_NEAR(static_cast<double>(rows), static_cast<double>(x.size()) / 7.0,
              0.05 * static_cast<double>(x.size()) / 7.0);
}

TEST(Held, ChannelsAreNamedWithTheOneThatIsLater) {
  Data d = healthy();
  d["q:hip"] = held(d["q:hip"], 5, 0);
  d["q:knee"] = held(d["q:knee"], 5, 1);
  const std::vector<HeldChannel> found = held_channels(d.view(), {});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].channel, "q:hip");
  EXPECT_EQ(found[0].rows, 5);
  EXPECT_EQ(found[0].late, 0);
  EXPECT_EQ(found[1].channel, "q:knee");
  EXPECT_EQ(found[1].rows, 5);
  EXPECT_EQ(found[1].late, 1);
  EXPECT_EQ(found[1].before, "q:hip");
  const GateReport report = inspect({d.view()}, joints());
  ASSERT_FALSE(report.refused()) << report.defects[0].message;
  EXPECT_TRUE(std::any_of(report.notes.begin(), report.notes.end(), [](const std::string& note) {
    return note.find("q:knee changes every 5 rows only, 1 row after q:hip") != std::string::npos;
  }));
}

TEST(Held, TheLoaderKeepsOneRowPerRefreshAndSpeaksOfTheFileAsItWas) {
  sanso::test::TempFolder folder;
  Data d = healthy();
  std::erase_if(d.columns, [](const auto& c) { return c.first[0] == 'p'; });
  const auto write = [&](const std::string& name) {
    const std::string file = (folder.path() / name).string();
    std::ofstream out(file);
    out.precision(12);
    out << "t";
    for (const auto& [column, values] : d.columns) out << "," << column;
    for (std::size_t k = 0; k < d.t.size(); ++k) {
      out << "\n" << d.t[k];
      for (const auto& [column, values] : d.columns) out << "," << values[k];
    }
    out << "\n";
    return file;
  };
  const std::string fresh = write("fresh.csv");
  d["dq:hip"] = held(d["dq:hip"], 4, 0);
  const std::string stale = write("stale.csv");
  const LoadedRecordings a = load_recordings({fresh}, joints()),
                         b = load_recordings({stale}, joints());
  ASSERT_FALSE(b.gate.refused()) << b.gate.defects[0].message;
  EXPECT_EQ(finite_values(a.recordings[0].find("dq:hip")).size(), d.t.size());
  EXPECT_NEAR(static_cast<double>(finite_values(b.recordings[0].find("dq:hip")).size()),
              static_cast<double>(d.t.size()) / 4.0, 0.02 * static_cast<double>(d.t.size()));
  EXPECT_EQ(finite_values(b.recordings[0].find("q:hip")).size(), d.t.size()) << "only what is held";
  EXPECT_EQ(b.hashes, data_hash({recording::read_recording(stale)}));
}

}  // namespace
}  // namespace sanso::diagnose
