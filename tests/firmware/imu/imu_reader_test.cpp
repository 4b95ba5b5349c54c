// The IMU reader over a sensor that refuses, fails, vanishes and comes back as another one.
#include "firmware/imu/imu_reader.h"

#include <gtest/gtest.h>

#include <deque>
#include <vector>

#include "tools/emulator/emulated_robot.h"

namespace sanso::firmware {
namespace {

using Report = std::vector<std::uint8_t>;

class CountingClock : public board::Clock {
 public:
  Nanoseconds now() override { return time += kMillisecond; }
  Nanoseconds time = 0;
};

/// A sensor as a list of reports.
class ListedHid : public board::HidSource {
 public:
  board::Bytes descriptor() override { return bytes; }
  Status set_feature(board::Bytes report) override {
    features.emplace_back(report.begin(), report.end());
    return report[0] == refused_id ? Status::io_error : Status::ok;
  }
  Result<std::size_t> get_feature(board::Buffer report) override {
    for (std::size_t i = 1; i < report.size(); ++i) report[i] = 0x60;
    return report.size();
  }
  Result<std::size_t> read(board::Buffer out, Nanoseconds) override {
    if (gone) return Status::io_error;
    if (reports.empty()) return std::size_t{0};
    const Report next = reports.front();
    reports.pop_front();
    std::copy(next.begin(), next.end(), out.begin());
    return next.size();
  }
  void reject() override { ++rejected; }

  Report bytes;
  std::deque<Report> reports;
  std::vector<Report> features;
  int refused_id = -1, rejected = 0;
  bool gone = false;
};

Report emulated() {
  const auto d = emulator::EmulatedRobot::imu_descriptor();
  return {d.begin(), d.end()};
}

void push_sample(ListedHid& hid) {
  hid.reports.push_back({1, 1, 3, 0x0C, 0x00, 0xDD, 0xFF, 0xE6, 0x03});
  hid.reports.push_back({2, 1, 3, 0x98, 0x3A, 0, 0, 0x3C, 0xF6, 0xFF, 0xFF, 0xC2, 0x98, 0x04, 0});
  hid.reports.push_back(
      {3, 1, 3, 0, 0, 0, 0, 0x85, 0x4C, 0x0D, 0, 0, 0, 0, 0, 0xDB, 0x01, 0x98, 0});
}

struct Rig {
  CountingClock clock;
  ListedHid hid;
  Mailbox<ImuSample> out;
  ImuReader reader{ImuSettings{}, hid, clock, out};
};

TEST(ImuReader, OneRefusedSwitchIsNotTheEndOfTheSensor) {
  Rig rig;
  rig.hid.bytes = emulated();
  rig.hid.refused_id = 2;
  push_sample(rig.hid);
  EXPECT_EQ(rig.reader.poll(0), Status::ok);
  EXPECT_EQ(rig.reader.refused_features(), 1u);
  ASSERT_TRUE(rig.out.update());
  EXPECT_NEAR(rig.out.front().accel[2], 0.998 * 9.80665, 1e-9);
}

TEST(ImuReader, SwitchesAreReadBeforeTheyAreWritten) {
  Rig rig;
  rig.hid.bytes = emulated();
  EXPECT_EQ(rig.reader.poll(0), Status::ok);
  ASSERT_EQ(rig.hid.features.size(), 3u);
  // state and power are fields of a whole byte, the interval of four: nothing of 0x60 is left there
  EXPECT_EQ(rig.hid.features[0], (Report{1, 1, 1, 5, 0, 0, 0}));
}

TEST(ImuReader, SaysAtOnceThatThereIsNoSensor) {
  Rig rig;
  EXPECT_EQ(rig.reader.poll(0), Status::not_ready);  // no descriptor: not there
  rig.hid.bytes = {0x05, 0x01, 0x09, 0x06, 0xA1, 0x01, 0xC0};
  EXPECT_EQ(rig.reader.poll(0), Status::unsupported);
  EXPECT_EQ(rig.hid.rejected, 1);
}

TEST(ImuReader, ASensorThatComesBackIsSwitchedOnAgainAHundredTimes) {
  Rig rig;
  rig.hid.bytes = emulated();
  for (int i = 0; i < 100; ++i) {
    rig.hid.gone = false;
    push_sample(rig.hid);
    rig.hid.features.clear();
    ASSERT_EQ(rig.reader.poll(0), Status::ok) << i;
    ASSERT_TRUE(rig.out.update()) << i;
    EXPECT_EQ(rig.hid.features.size(), 3u) << i;
    rig.hid.gone = true;
    EXPECT_EQ(rig.reader.poll(0), Status::io_error) << i;
  }
  EXPECT_EQ(rig.out.front().sequence, 100u);
}

}  // namespace
}  // namespace sanso::firmware
