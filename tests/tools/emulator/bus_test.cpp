// The emulated bus as a master sees it: who answers, when, with which status; what each bus fault
// looks like.
#include <gtest/gtest.h>

#include "tests/tools/emulator/master.h"
#include "tests/tools/emulator/more_instructions.h"

namespace sanso::emulator {
namespace {

using servo_bus::StatusError;
const std::vector<std::uint8_t> kLegs{7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18};

struct Bus : testing::Test {
  EmulatedRobot robot{plant::load_world("nominal"), 1};
  Master master{robot};
  servo_bus::PacketBuffer wire;

  std::vector<servo_bus::Packet> read_legs() {
    servo_bus::encode_sync_read(wire, xm::kFeedbackAddress, xm::kFeedbackBytes, kLegs);
    return master.exchange(wire);
  }
};

TEST_F(Bus, NoServoAnswersBeforeTheBoardSwitchesThemOn) {
  servo_bus::encode_ping(wire, 7);
  EXPECT_FALSE(master.one(wire));
  servo_bus::encode_ping(wire, servo_bus::opencr::kId);
  EXPECT_TRUE(master.one(wire));
  master.stand_by();
  servo_bus::encode_ping(wire, 7);
  const auto reply = master.one(wire);
  ASSERT_TRUE(reply);
  EXPECT_EQ(servo_bus::get_u16(reply->parameters.view()), 1020);
  EXPECT_EQ(reply->parameters[2], 45);
}

TEST_F(Bus, BroadcastPingIsAnsweredByAllInOrderOfId) {
  master.stand_by();
  servo_bus::encode_ping(wire, servo_bus::kBroadcastId);
  const auto replies = master.exchange(wire, 10 * kMillisecond);
  ASSERT_EQ(replies.size(), 21u);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(replies[i].id, i + 1);
  EXPECT_EQ(replies[20].id, 200);
}

TEST_F(Bus, SyncReadTakesItsTimeOnTheWire) {
  master.stand_by();
  const Nanoseconds sent = robot.now();
  const auto replies = read_legs();
  ASSERT_EQ(replies.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(replies[i].id, kLegs[i]);
  // 26 bytes out, 12 x 21 bytes back (some with stuffing), 12 x 32 us of delay, 5 us a byte
  const double us = static_cast<double>(master.last_packet_time - sent) / 1e3;
  EXPECT_GE(us, (26 + 252) * 5 + 12 * 32);
  EXPECT_LE(us, (26 + 252 + 36) * 5 + 12 * 32);
}

TEST_F(Bus, FastSyncReadIsOneFrameWithABlockForEach) {
  master.stand_by();
  servo_bus::encode_fast_sync_read(wire, xm::kFeedbackAddress, xm::kFeedbackBytes, kLegs);
  const auto replies = master.exchange(wire);
  ASSERT_EQ(replies.size(), 1u);
  servo_bus::FastReplyReader reader(master.frame());
  for (const std::uint8_t id : kLegs) {
    const auto block = reader.next(xm::kFeedbackBytes);
    ASSERT_TRUE(block.ok());
    EXPECT_EQ(block->id, id);
    const auto feedback = xm::decode_feedback(block->data);
    EXPECT_NEAR(servo_bus::position_rad(feedback.position_raw), robot.truth().q[id - 1], 0.01);
  }
}

TEST_F(Bus, BulkReadAndHeldWrites) {
  master.stand_by();
  encode_bulk(wire, servo_bus::Instruction::bulk_read,
              {{7, xm::kPresentInputVoltage.address, 2}, {8, xm::kPresentTemperature.address, 1}});
  const auto replies = master.exchange(wire);
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_EQ(servo_bus::get_u16(replies[0].parameters.view()), 120);
  EXPECT_EQ(replies[1].parameters.size(), 1u);

  encode_reg_write(wire, 7, xm::kLed.address, {1});
  ASSERT_TRUE(master.one(wire));
  EXPECT_EQ(master.read(7, xm::kLed), 0);
  encode_action(wire, 7);
  ASSERT_TRUE(master.one(wire));
  EXPECT_EQ(master.read(7, xm::kLed), 1);
}

TEST_F(Bus, AccessRules) {
  master.stand_by();
  EXPECT_EQ(master.write(7, xm::kPresentPosition, 0), StatusError::access);
  // EEPROM with torque on
  EXPECT_EQ(master.write(7, xm::kReturnDelayTime, 1), StatusError::access);
  EXPECT_EQ(master.write(7, xm::kTorqueEnable, 2), StatusError::data_range);
  EXPECT_EQ(master.write(7, xm::kGoalPosition, 4096), StatusError::data_limit);
  EXPECT_EQ(master.write(7, xm::kTorqueEnable, 0), StatusError::none);
  EXPECT_EQ(master.write(7, xm::kReturnDelayTime, 0), StatusError::none);
  EXPECT_EQ(master.write_bytes(7, 660, 4, 0), StatusError::data_range);
  EXPECT_EQ(master.write(7, xm::kOperatingMode, 0), StatusError::data_range);
}

TEST_F(Bus, IndirectDataReachesTheRegisterItPointsAt) {
  master.stand_by();
  for (int i = 0; i < 2; ++i) {
    master.write_bytes(7, static_cast<std::uint16_t>(xm::kIndirectAddress1 + 2 * i), 2,
                       xm::kPositionPGain.address + i);
  }
  EXPECT_EQ(master.write_bytes(7, xm::kIndirectData1, 2, 333), StatusError::none);
  EXPECT_EQ(master.read(7, xm::kPositionPGain), 333);
}

TEST_F(Bus, DamagedInstructionIsAnsweredWithCrcError) {
  master.stand_by();
  servo_bus::encode_read(wire, 7, 132, 4);
  wire[9] ^= 0x40;
  const auto reply = master.one(wire);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status_error(), StatusError::crc_mismatch);
}

TEST_F(Bus, RebootIsSilentForASecondAndLosesTheGains) {
  master.stand_by(560);
  servo_bus::encode_reboot(wire, 7);
  ASSERT_TRUE(master.one(wire));
  EXPECT_FALSE(master.read(7, xm::kPositionPGain));
  robot.advance(robot.now() + 1100 * kMillisecond);
  EXPECT_EQ(master.read(7, xm::kPositionPGain), 800);
  EXPECT_EQ(master.read(7, xm::kTorqueEnable), 0);
}

TEST_F(Bus, TwoTalkersDestroyEachOther) {
  master.stand_by();
  servo_bus::encode_sync_read(wire, xm::kFeedbackAddress, xm::kFeedbackBytes, kLegs);
  robot.bus_write(wire.view());
  robot.advance(robot.now() + 500 * kMicrosecond);  // replies are under way
  servo_bus::encode_ping(wire, 3);
  EXPECT_LT(master.exchange(wire).size(), 12u);
}

// --- faults --------------------------------------------------------------------------------------

struct BusFaults : Bus {
  void strike(FaultKind kind, int id, double probability = 1.0, double amount = 0) {
    robot.faults().add({kind, id, 0, INT64_MAX, probability, amount});
    robot.advance(robot.now() + 2 * kMillisecond);  // a cable fault shows at the servo's next loop
  }
  void SetUp() override { master.stand_by(); }
};

TEST_F(BusFaults, DropLosesOneReplyAndKeepsTheChain) {
  strike(FaultKind::bus_drop, 9);
  EXPECT_EQ(read_legs().size(), 11u);
}

TEST_F(BusFaults, SilentServoKillsTheRepliesBehindIt) {
  strike(FaultKind::servo_silent, 9);
  EXPECT_EQ(read_legs().size(), 2u);
}

TEST_F(BusFaults, SilentServoCutsTheFastReplyShortButNotTheBlocksBeforeIt) {
  strike(FaultKind::servo_silent, 9);
  servo_bus::encode_fast_sync_read(wire, xm::kFeedbackAddress, xm::kFeedbackBytes, kLegs);
  EXPECT_TRUE(master.exchange(wire).empty());
  servo_bus::FastReplyReader reader(master.pending());
  EXPECT_TRUE(reader.next(xm::kFeedbackBytes).ok());
  EXPECT_TRUE(reader.next(xm::kFeedbackBytes).ok());
  EXPECT_EQ(reader.next(xm::kFeedbackBytes).status(), Status::empty);
}

TEST_F(BusFaults, CorruptTruncateGarbageNeverYieldAWrongValue) {
  for (const FaultKind kind :
       {FaultKind::bus_corrupt, FaultKind::bus_truncate, FaultKind::bus_garbage}) {
    robot.faults().clear();
    strike(kind, 0, 0.5);
    for (int round = 0; round < 20; ++round) {
      for (const auto& packet : read_legs()) {
        ASSERT_EQ(packet.parameters.size(), xm::kFeedbackBytes) << to_string(kind);
        const auto feedback = xm::decode_feedback(packet.parameters.view());
        EXPECT_NEAR(servo_bus::position_rad(feedback.position_raw), robot.truth().q[packet.id - 1],
                    0.02);
      }
    }
  }
}

TEST_F(BusFaults, DuplicateRepliesArriveTwice) {
  strike(FaultKind::bus_duplicate, 9);
  EXPECT_EQ(read_legs().size(), 13u);
}

TEST_F(BusFaults, DelayShiftsTheReply) {
  const Nanoseconds before = robot.now();
  read_legs();
  const Nanoseconds usual = master.last_packet_time - before;
  strike(FaultKind::bus_delay, 9, 1.0, 0.002);
  const Nanoseconds sent = robot.now();
  read_legs();
  EXPECT_NEAR(static_cast<double>(master.last_packet_time - sent - usual), 2e6, 0.3e6);
}

TEST_F(BusFaults, SwitchesActOnlyBetweenTheirTimes) {
  robot.faults().add(
      {FaultKind::servo_silent, 7, robot.now() + kSecond, robot.now() + 2 * kSecond});
  EXPECT_EQ(read_legs().size(), 12u);
  robot.advance(robot.now() + kSecond);
  EXPECT_EQ(read_legs().size(), 0u);
  robot.advance(robot.now() + kSecond);
  EXPECT_EQ(read_legs().size(), 12u);
}

TEST(FaultNames, RoundTrip) {
  for (const FaultKind kind : all_fault_kinds())
    EXPECT_EQ(fault_from_string(to_string(kind)), kind);
  EXPECT_FALSE(fault_from_string("nonsense"));
}

}  // namespace
}  // namespace sanso::emulator
