// Durations as histograms: every duration falls into the bin that says so, quantiles are not below
// what they stand for, and the file holds what was counted.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "firmware/log/times_file.h"
#include "tests/support/temp_folder.h"

namespace sanso::firmware {
namespace {

TEST(TimeHistogram, EveryDurationIsInsideItsBin) {
  for (std::size_t bin = 0; bin + 1 < TimeHistogram::kBins; ++bin) {
    EXPECT_LT(TimeHistogram::begin_of(bin), TimeHistogram::end_of(bin)) << bin;
    EXPECT_EQ(TimeHistogram::end_of(bin), TimeHistogram::begin_of(bin + 1)) << "no gaps";
  }
  for (Nanoseconds d = 0; d < 200 * kMillisecond; d = d + d / 7 + 1) {
    const std::size_t bin = TimeHistogram::bin_of(d);
    EXPECT_GE(d, TimeHistogram::begin_of(bin)) << d;
    EXPECT_LT(d, TimeHistogram::end_of(bin)) << d;
  }
}

TEST(TimeHistogram, QuantilesAreUpperBoundsWithinABin) {
  TimeHistogram h;
  EXPECT_EQ(h.quantile(0.99), 0);
  for (int us = 1; us <= 1000; ++us) h.add(us * kMicrosecond);
  EXPECT_EQ(h.count(), 1000u);
  EXPECT_EQ(h.longest(), kMillisecond);
  for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const double exact_us = 1000 * share;
    const double found_us = static_cast<double>(h.quantile(share)) / kMicrosecond;
    EXPECT_GE(found_us, exact_us) << share;
    EXPECT_LE(found_us, exact_us * 1.26 + 1) << share;
  }
}

TEST(TimesFile, HoldsAllThatWasCounted) {
  TickTimes times;
  for (int k = 0; k < 30; ++k) times.wake.add(k * kMicrosecond);
  for (int k = 0; k < 20; ++k) times.reply.add(2 * kMillisecond);
  times.tick.add(kSecond);  // beyond the last bin
  const test::TempFolder folder;
  const std::string file = (folder.path() / "times.csv").string();
  ASSERT_TRUE(write_times(times, file));
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "less_than_us,wake,tick,reply,imu_age");
  std::array<long, 4> sums{};
  while (std::getline(in, line)) {
    std::istringstream cells(line.substr(line.find(',') + 1));
    std::string cell;
    for (long& sum : sums)
      if (std::getline(cells, cell, ',')) sum += std::stol(cell);
  }
  EXPECT_EQ(sums, (std::array<long, 4>{30, 1, 20, 0}));
  EXPECT_NE(times_line(times).find("1 ticks"), std::string::npos);
  EXPECT_FALSE(write_times(times, "/nowhere/times.csv"));
}

}  // namespace
}  // namespace sanso::firmware
