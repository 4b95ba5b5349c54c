// The flight record: the ticks before and after a fault, whole or not there, readable as a
// recording.
#include "firmware/log/flight_recorder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>

#include "firmware/exchange/faults.h"
#include "tools/recording/csv_reader.h"

namespace sanso::firmware {
namespace {

namespace fs = std::filesystem;

struct Recorder : testing::Test {
  fs::path folder;
  std::unique_ptr<Handover> handover = std::make_unique<Handover>();
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "sanso_flight_XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder); }

  /// Ticks `first`..`last`, a fault from `fault_tick` on; how many files were written.
  int fly(FlightRecorder& recorder, int first, int last, int fault_tick,
          int cleared_tick = 1'000'000) {
    int written = 0;
    for (int k = first; k <= last; ++k) {
      LogRecord record;
      record.observation.tick = static_cast<std::uint64_t>(k);
      record.observation.time = k * kTickPeriod;
      record.observation.x[model::kXQuat] = 1.0;
      record.observation.x[model::kXJoint + 3] = 0.001 * k;
      record.observation.u_out[3] = 0.5;
      record.observation.voltage_V = 12.1F;
      record.observation.fault =
          k >= fault_tick && k < cleared_tick ? static_cast<std::uint16_t>(Fault::imu_silent) : 0;
      EXPECT_TRUE(handover->log.push(record));
      written += recorder.poll() ? 1 : 0;
    }
    return written;
  }
};

TEST_F(Recorder, AFaultLeavesOneFileWithTheMinuteBeforeAndHalfASecondAfter) {
  FlightRecorder recorder(*handover, folder, "0badb007");
  EXPECT_EQ(fly(recorder, 0, 8000, 7900), 1);
  const recording::Recording read = recording::read_csv(recorder.last_file());
  ASSERT_EQ(read.rows(), FlightRecorder::kTicksKept);
  EXPECT_NEAR(read.t.back(), 79.0 + 0.01 * FlightRecorder::kTicksAfterFault, 1e-9);
  EXPECT_NEAR(read.find("q:r_knee").back(), 7.95, 1e-6);
  EXPECT_NEAR(read.find("u:r_knee").back(), 0.5, 1e-6);
  for (const char* channel : {"dq:l_ank_roll", "i:l_knee", "volt", "base_p:z", "base_q:w",
                              "base_v:x", "base_w:z", "imu_acc:z"})
    EXPECT_TRUE(read.has(channel)) << channel;
}

TEST_F(Recorder, TheFileIsNamedAfterTheFaultEvenWhenItWasClearedAtOnce) {
  FlightRecorder recorder(*handover, folder, "0badb007");
  EXPECT_EQ(fly(recorder, 0, 200, 100, 110), 1);
  EXPECT_EQ(fs::path(recorder.last_file()).filename(), "F30-0badb007-1000ms.csv");
}

TEST_F(Recorder, WithoutAFaultNothingIsWritten) {
  FlightRecorder recorder(*handover, folder, "0badb007");
  EXPECT_EQ(fly(recorder, 0, 500, 1000), 0);
  EXPECT_TRUE(fs::is_empty(folder));
  EXPECT_EQ(recorder.records().size(), 501u);
}

TEST_F(Recorder, AFolderThatIsNotThereIsSaidAndTheNextFaultTriesAgain) {
  FlightRecorder recorder(*handover, folder / "missing", "0badb007");
  EXPECT_EQ(fly(recorder, 0, 200, 100), 0);
  EXPECT_NE(recorder.error().find("missing/F30"), std::string::npos) << recorder.error();
  EXPECT_TRUE(recorder.last_file().empty());
  fs::create_directories(folder / "missing");
  fly(recorder, 201, 220, 1000);  // cleared
  EXPECT_EQ(fly(recorder, 221, 400, 300), 1);
  EXPECT_TRUE(recorder.error().empty());
}

}  // namespace
}  // namespace sanso::firmware
