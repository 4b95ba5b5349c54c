// The black box: every tick in files that the recording reader opens, whole or cut; rotation,
// room, and what a disk that refuses costs.
#include "firmware/log/black_box.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "tools/recording/mcap_file.h"
#include "tools/recording/mcap_recording.h"

namespace sanso::firmware {
namespace {

namespace fs = std::filesystem;

LogRecord record_of(int k) {
  LogRecord record;
  wire::Observation& o = record.observation;
  o.tick = static_cast<std::uint64_t>(k);
  o.time = k * kTickPeriod;
  o.x[model::kXQuat] = 0.6;
  o.x[model::kXQuat + 3] = 0.8;
  o.x[model::kXJoint + 3] = 0.001 * k;
  o.x[model::kXJointRate + 3] = 0.1;
  o.u_out[3] = 0.5;
  o.current_raw[9] = 100;
  o.imu_acc = {0, 0.5, 9.81};
  o.imu_gyro = {1, 2, 3};
  o.x.segment<3>(model::kXVel + 3) = math::Vec3(1, 2, 3);
  o.voltage_V = 12.5F;
  return record;
}

struct Box : testing::Test {
  fs::path folder;
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "sanso_box_XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder); }
  fs::path file(int number) const {
    return folder / ("0badb007-000" + std::to_string(number) + ".mcap");
  }
  BlackBox box(BlackBoxLimits limits = {}, const std::string& boot = "0badb007") const {
    return {folder, boot, limits, {{"robot", "test"}}};
  }
};

TEST_F(Box, IsARecordingWithEveryTickInIt) {
  {
    BlackBox written = box();
    for (int k = 1; k <= 130; ++k) written.take(record_of(k));
    EXPECT_EQ(written.error(), "");
    EXPECT_EQ(written.file(), file(1));
  }
  const recording::Recording read = recording::read_recording(file(1));
  ASSERT_EQ(read.rows(), 130u);
  EXPECT_FALSE(read.cut);
  for (std::size_t k = 0; k < 130; ++k) {
    EXPECT_NEAR(read.t[k], 0.01 * static_cast<double>(k + 1), 1e-9);
    EXPECT_NEAR(read.find("q:r_knee")[k], 0.001 * static_cast<double>(k + 1), 1e-12);
  }
  EXPECT_EQ(read.find("dq:r_knee")[0], 0.1);
  EXPECT_EQ(read.find("u:r_knee")[7], 0.5);
  EXPECT_NEAR(read.find("i:l_knee")[7], 0.269, 1e-12);
  EXPECT_EQ(read.find("volt")[7], 12.5);
  EXPECT_EQ(read.find("base_q:w")[7], 0.6);
  EXPECT_EQ(read.find("base_q:z")[7], 0.8);
  EXPECT_EQ(read.find("base_w:y")[7], 2);
  EXPECT_EQ(read.find("imu_acc:z")[7], 9.81);
}

TEST_F(Box, ReadableWhileItIsWrittenAndAFaultIsWrittenAtOnce) {
  BlackBox written = box();
  for (int k = 0; k < 45; ++k) written.take(record_of(k));
  // the newest fifth of a second waits in memory
  EXPECT_EQ(recording::read_mcap(file(1)).rows(), 41u);
  LogRecord fault = record_of(45);
  fault.observation.fault = 30;
  written.take(fault);
  const recording::Recording read = recording::read_mcap(file(1));
  EXPECT_EQ(read.rows(), 46u);
  EXPECT_TRUE(read.cut);
}

TEST_F(Box, CutAtEveryByteItsWholeChunksAreRead) {
  {
    BlackBox written = box();
    for (int k = 0; k < 30; ++k) written.take(record_of(k));
  }
  std::set<std::size_t> seen;
  std::size_t before = 30;
  for (std::size_t size = fs::file_size(file(1)) - 1; size >= 8; --size) {
    fs::resize_file(file(1), size);
    std::size_t rows = 0;
    (void)recording::read_mcap_messages(
        file(1), [&](const recording::McapChannel& channel, std::uint64_t, std::string_view) {
          rows += channel.topic == "/joint_states" ? 1 : 0;
        });
    ASSERT_LE(rows, before) << size;
    seen.insert(before = rows);
  }
  EXPECT_EQ(seen, (std::set<std::size_t>{0, 21, 30}));
}

TEST_F(Box, FilesAreClosedByTimeAndNumberedOn) {
  {
    BlackBox written = box({.file_time = 2 * kSecond});
    for (int k = 0; k < 500; ++k) written.take(record_of(k));
  }
  for (const int number : {1, 2}) {
    const recording::Recording read = recording::read_recording(file(number));
    EXPECT_EQ(read.rows(), 201u);
    EXPECT_FALSE(read.cut);
  }
  EXPECT_EQ(recording::read_recording(file(3)).rows(), 98u);
  BlackBox again = box();  // the program started anew in the same boot
  again.take(record_of(1));
  EXPECT_EQ(again.file(), file(4));
  BlackBox next_boot = box({}, "12345678");
  next_boot.take(record_of(1));
  EXPECT_EQ(next_boot.file(), folder / "12345678-0001.mcap");
}

TEST_F(Box, TheOldestGoWhenRoomIsShortAndNothingElse) {
  const fs::path precious = folder / "my-walk.mcap";
  fs::copy_file("/proc/self/exe", precious);
  const auto old = fs::file_time_type::clock::now() - std::chrono::hours(1);
  fs::last_write_time(precious, old);
  BlackBox written = box({.file_bytes = 20'000, .keep_bytes = 65'000});
  for (int k = 0; k < 3000; ++k) {
    written.take(record_of(k));
    // files of one second are older than those that follow, on any file system
    if (k % 100 == 99) fs::last_write_time(written.file(), old + std::chrono::seconds(k));
  }
  std::uintmax_t total = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.path() != precious) total += entry.file_size();
  EXPECT_LE(total, 70'000u) << "a file may grow by one chunk beyond its size";
  EXPECT_GE(total, 30'000u);
  EXPECT_FALSE(fs::exists(file(1)));
  EXPECT_TRUE(fs::exists(written.file()));
  EXPECT_TRUE(fs::exists(precious));
}

TEST_F(Box, ADiskThatRefusesCostsTicksThatAreCounted) {
  BlackBox written = box();
  fs::remove_all(folder);
  for (int k = 0; k < 500; ++k) written.take(record_of(k));
  EXPECT_NE(written.error().find("device.log_directory"), std::string::npos) << written.error();
  EXPECT_EQ(written.lost(), 500u);
  fs::create_directories(folder);
  for (int k = 500; k < 1100; ++k) written.take(record_of(k));
  EXPECT_EQ(written.error(), "");
  EXPECT_EQ(written.lost(), 1000u) << "another try after ten seconds";
  written.close();
  EXPECT_EQ(recording::read_recording(written.file()).rows(), 100u);
}

TEST_F(Box, WhatTheQueueDroppedIsCountedToo) {
  BlackBox written = box();
  LogRecord record = record_of(7);
  record.dropped = 3;
  written.take(record);
  EXPECT_EQ(written.lost(), 3u);
}

TEST_F(Box, WithoutAFolderNothingIsWritten) {
  BlackBox written("", "0badb007", {}, {});
  written.take(record_of(1));
  EXPECT_EQ(written.error(), "");
  EXPECT_TRUE(written.file().empty());
}

}  // namespace
}  // namespace sanso::firmware
