// Who has to answer what, and when: return level and delay, broadcasts, writes to several, alert
// bit, the OpenCR board.
#include <gtest/gtest.h>

#include "tests/tools/emulator/master.h"
#include "tests/tools/emulator/more_instructions.h"

namespace sanso::emulator {
namespace {

namespace reg = servo_bus::opencr;
using servo_bus::StatusError;

struct BusRules : testing::Test {
  EmulatedRobot robot{plant::load_world("nominal"), 1};
  Master master{robot};
  servo_bus::PacketBuffer wire;
  void SetUp() override { master.stand_by(); }

  bool ping(int id) {
    servo_bus::encode_ping(wire, static_cast<std::uint8_t>(id));
    return master.one(wire).has_value();
  }
  /// Time from the end of a ping to the end of its answer [us].
  double answer_us(int id) {
    servo_bus::encode_ping(wire, static_cast<std::uint8_t>(id));
    const Nanoseconds sent = robot.now() + servo_bus::wire_time_ns(wire.size(), 2'000'000);
    master.exchange(wire, 2 * kMillisecond);
    return static_cast<double>(master.last_packet_time - sent) / 1e3;
  }
  std::vector<std::uint8_t> read_board(std::uint16_t address, std::uint16_t length) {
    servo_bus::encode_read(wire, reg::kId, address, length);
    const auto packet = master.one(wire);
    return packet ? std::vector<std::uint8_t>(packet->parameters.begin(), packet->parameters.end())
                  : std::vector<std::uint8_t>{};
  }
};

TEST_F(BusRules, StatusReturnLevelSaysWhatIsAnswered) {
  ASSERT_EQ(master.write(7, xm::kStatusReturnLevel, 1), StatusError::none);
  master.write(7, xm::kLed, 1);
  EXPECT_FALSE(master.answered);
  EXPECT_EQ(master.read(7, xm::kLed), 1);
  EXPECT_EQ(master.read(7, xm::kStatusReturnLevel), 1);
  master.write(7, xm::kStatusReturnLevel, 0);
  EXPECT_FALSE(master.read(7, xm::kLed));
  EXPECT_TRUE(ping(7));
  EXPECT_EQ(master.read(8, xm::kLed), 0) << "the others are not concerned";
}

TEST_F(BusRules, ReturnDelayComesBeforeTheAnswer) {
  const double before = answer_us(7);
  master.write(7, xm::kTorqueEnable, 0);
  ASSERT_EQ(master.write(7, xm::kReturnDelayTime, 101), StatusError::none);
  EXPECT_NEAR(answer_us(7) - before, 200.0, 1.0);  // 100 units of 2 us
  // 14 bytes at 2 Mbit/s, delay 1, latency of the servo
  EXPECT_NEAR(before, 14 * 5 + 2 + 30, 1.0);
}

TEST_F(BusRules, AServoSetToAnotherBaudRateAnswersTheWriteAndIsSilentFromThen) {
  master.write(7, xm::kTorqueEnable, 0);
  EXPECT_EQ(master.read(7, xm::kBaudRate), 4);
  EXPECT_EQ(master.write(7, xm::kBaudRate, 3), StatusError::none);
  EXPECT_FALSE(ping(7));
  master.write(7, xm::kBaudRate, 4);
  EXPECT_FALSE(master.answered) << "it cannot be called back at the old rate";
  EXPECT_TRUE(ping(8)) << "the others are not concerned";
}

TEST(BaudRate, ServosAreSetUpForTheLinesRate) {
  EmulatedRobot robot{plant::load_world("nominal"), 1, 1'000'000};
  Master master{robot};
  master.stand_by();
  EXPECT_EQ(master.read(7, xm::kBaudRate), 3);
  EXPECT_THROW(EmulatedRobot(plant::load_world("nominal"), 1, 12345), std::invalid_argument);
}

TEST_F(BusRules, BulkWriteReachesEachWithItsOwnRegisters) {
  encode_bulk(wire, servo_bus::Instruction::bulk_write,
              {{7, xm::kPositionPGain.address, 2, {0x2C, 0x01}}, {8, xm::kLed.address, 1, {1}}});
  EXPECT_TRUE(master.exchange(wire).empty()) << "nobody answers a broadcast";
  EXPECT_EQ(master.read(7, xm::kPositionPGain), 300);
  EXPECT_EQ(master.read(7, xm::kLed), 0);
  EXPECT_EQ(master.read(8, xm::kLed), 1);
}

TEST_F(BusRules, FastBulkReadIsOneFrame) {
  encode_bulk(wire, servo_bus::Instruction::fast_bulk_read,
              {{7, xm::kPresentInputVoltage.address, 2}, {8, xm::kPositionPGain.address, 2}});
  ASSERT_EQ(master.exchange(wire).size(), 1u);
  servo_bus::FastReplyReader reader(master.frame());
  const auto first = reader.next(2), second = reader.next(2);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(servo_bus::get_u16(first->data), 120);
  EXPECT_EQ(servo_bus::get_u16(second->data), 560);
}

TEST_F(BusRules, HeldWritesWaitForTheBroadcastAction) {
  for (const std::uint8_t id : {7, 8}) {
    encode_reg_write(wire, id, xm::kLed.address, {1});
    ASSERT_TRUE(master.one(wire));
    EXPECT_EQ(master.read(id, xm::kRegisteredInstruction), 1);
  }
  encode_action(wire, servo_bus::kBroadcastId);
  EXPECT_TRUE(master.exchange(wire).empty());
  for (const int id : {7, 8}) {
    EXPECT_EQ(master.read(id, xm::kLed), 1);
    EXPECT_EQ(master.read(id, xm::kRegisteredInstruction), 0);
  }
  encode_action(wire, 9);
  const auto nothing_held = master.one(wire);
  ASSERT_TRUE(nothing_held);
  EXPECT_EQ(nothing_held->status_error(), StatusError::result_fail);
}

TEST_F(BusRules, AHardwareErrorShowsInEveryAnswer) {
  robot.faults().add({FaultKind::servo_overload, 7});
  robot.advance(robot.now() + 5 * kMillisecond);
  servo_bus::encode_ping(wire, 7);
  const auto answer = master.one(wire);
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->alert());
  EXPECT_EQ(master.read(7, xm::kHardwareErrorStatus), xm::kErrorOverload);
  EXPECT_EQ(master.write(7, xm::kTorqueEnable, 1), StatusError::result_fail)
      << "only a reboot brings the torque back";
}

TEST_F(BusRules, SettingsThatAreNotEmulatedAreRefused) {
  master.write(7, xm::kTorqueEnable, 0);
  for (const auto* r : {&xm::kDriveMode, &xm::kHomingOffset, &xm::kStartupConfiguration,
                        &xm::kSecondaryId, &xm::kFeedforwardVelocityGain}) {
    EXPECT_EQ(master.write(7, *r, 1), StatusError::data_range) << r->name;
    EXPECT_EQ(master.read(7, *r), r->initial_raw) << r->name;
  }
}

TEST_F(BusRules, TheBoardTellsVoltageButtonsAndItsOwnImu) {
  robot.advance(robot.now() + 3 * kSecond);  // let go after one, and come to rest
  EXPECT_EQ(read_board(reg::kVoltage, 1), std::vector<std::uint8_t>{120});
  const auto imu = read_board(reg::kAccelerometer, 6);
  ASSERT_EQ(imu.size(), 6u);
  EXPECT_NEAR(servo_bus::get_i16(std::span(imu).subspan(4)), reg::kAccelCountsPerG,
              0.05 * reg::kAccelCountsPerG);
  robot.press(reg::kButtonStart);
  EXPECT_EQ(read_board(reg::kButtons, 1), std::vector<std::uint8_t>{reg::kButtonStart});
}

TEST_F(BusRules, TheBoardsSensorsAreNotWritable) {
  EXPECT_EQ(master.write_bytes(reg::kId, reg::kVoltage, 1, 0), StatusError::access);
  EXPECT_EQ(master.write_bytes(reg::kId, reg::kLed, 1, 1), StatusError::none);
  EXPECT_EQ(master.write_bytes(reg::kId, reg::kTableBytes, 1, 1), StatusError::data_range);
}

}  // namespace
}  // namespace sanso::emulator
