// The bus master against servos that answer real packets, and against a port that answers nonsense.
#include "firmware/bus/bus_master.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

#include "firmware/bus/bus_setup.h"
#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/opencr.h"
#include "shared/servo_bus/parser.h"
#include "shared/servo_bus/xm430.h"
#include "tools/bench/instant_bus.h"

namespace sanso::firmware {
namespace {

class StillClock : public board::Clock {
 public:
  Nanoseconds now() override { return time; }
  Nanoseconds time = 0;
};

/// Passes bytes through and spoils the replies on request.
class SpoiledPort : public board::SerialPort {
 public:
  Status write(board::Bytes data) override {
    written.assign(data.begin(), data.end());
    return gone ? Status::io_error : bus.write(data);
  }
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override {
    if (gone) return Status::io_error;
    if (deadline == 0) return bus.read(buffer, 0);  // draining
    std::array<std::uint8_t, 1024> raw;
    const Result<std::size_t> n = bus.read(raw, deadline);
    std::vector<std::uint8_t> bytes(raw.begin(), raw.begin() + static_cast<long>(*n));
    if (spoil && !bytes.empty()) spoil(bytes);
    std::copy(bytes.begin(), bytes.end(), buffer.begin());
    return bytes.size();
  }
  Status ready() override { return Status::ok; }

  bench::InstantBus bus;
  std::function<void(std::vector<std::uint8_t>&)> spoil;
  std::vector<std::uint8_t> written;
  bool gone = false;
};

class BusMasterTest : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override { master.use_fast_read(GetParam()); }
  BusSettings settings;
  SpoiledPort port;
  StillClock clock;
  BusMaster master{settings, port, clock};
  ServoReadings readings;
};

TEST_P(BusMasterTest, ReadsEveryServo) {
  port.bus.poke(3, 132, 4, 2048 - 652);
  port.bus.poke(3, 128, 4, -10);
  port.bus.poke(3, 126, 2, -37);
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_EQ(readings.answered, model::kNumJoints);
  EXPECT_NEAR(readings.servo[3].position_rad, -1.0, 1e-3);
  EXPECT_NEAR(readings.servo[3].velocity_rad_s, -0.2398, 1e-3);
  EXPECT_EQ(readings.servo[3].current_raw, -37);
  EXPECT_EQ(master.counters().lost, 0u);
}

TEST_P(BusMasterTest, StuffedRepliesAreReadRight) {
  // current -1, velocity -3: FF FF FD FF on the wire
  port.bus.poke(0, 126, 2, -1);
  port.bus.poke(0, 128, 4, -3);
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_EQ(readings.answered, model::kNumJoints);
  EXPECT_EQ(readings.servo[0].current_raw, -1);
}

TEST_P(BusMasterTest, ThoseBeforeASilentServoAreUsedAndTheSilentOneIsAskedLast) {
  const int silent = 7;
  port.bus.silence_from(silent);
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_EQ(readings.answered, silent);
  EXPECT_EQ(readings.servo[silent].age_ticks, 1);
  EXPECT_EQ(master.counters().lost, static_cast<std::uint32_t>(model::kNumJoints - silent));
  port.bus.silence_from(kNumServos);
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_EQ(readings.answered, model::kNumJoints);
  // ids in the request begin behind header, instruction, address and length; CRC at the end
  ASSERT_GT(port.written.size(), 14u);
  EXPECT_EQ(port.written[port.written.size() - 3], kServoIds[silent]);
}

TEST_P(BusMasterTest, ADamagedByteCostsOnlyItsServoOrThoseBehind) {
  // a data byte
  port.spoil = [](std::vector<std::uint8_t>& bytes) { bytes[bytes.size() / 2 + 12] ^= 0x40; };
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_GE(readings.answered, model::kNumJoints / 2 - 1);
  EXPECT_LT(readings.answered, model::kNumJoints);
  EXPECT_EQ(master.counters().corrupt, 1u);
  port.spoil = nullptr;
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_EQ(readings.answered, model::kNumJoints) << "recovers at once";
}

TEST_P(BusMasterTest, ATruncatedReplyGivesTheServosBeforeTheCut) {
  port.spoil = [](std::vector<std::uint8_t>& bytes) { bytes.resize(bytes.size() / 2); };
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_GE(readings.answered, 4);
  EXPECT_LT(readings.answered, model::kNumJoints);
}

TEST_P(BusMasterTest, GarbageBeforeTheReplyIsSkipped) {
  port.spoil = [](std::vector<std::uint8_t>& bytes) {
    const std::vector<std::uint8_t> noise = {0xFF, 0x12, 0xFF, 0xFF, 0x00, 0x55};
    bytes.insert(bytes.begin(), noise.begin(), noise.end());
  };
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_EQ(readings.answered, model::kNumJoints);
}

TEST_P(BusMasterTest, RandomNoiseNeverBringsAWrongReading) {
  const unsigned seed = 17;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  port.spoil = [&](std::vector<std::uint8_t>& bytes) {
    for (int k = 0; k < 5; ++k)
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << (random() % 8));
  };
  for (int n = 0; n < 2000; ++n) {
    master.read_feedback(model::kNumJoints, readings);
    for (std::size_t s = 0; s < model::kNumJoints; ++s)
      if (readings.servo[s].known) {
        ASSERT_EQ(readings.servo[s].position_raw, 2048);
      }
  }
}

TEST_P(BusMasterTest, AGonePortIsSaid) {
  port.gone = true;
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_TRUE(readings.port_gone);
  EXPECT_EQ(readings.answered, 0);
}

TEST_P(BusMasterTest, GoalsReachTheServosInOrder) {
  std::array<std::int32_t, model::kNumJoints> goals{};
  for (std::size_t s = 0; s < goals.size(); ++s) goals[s] = 2000 + static_cast<std::int32_t>(s);
  ASSERT_EQ(master.write_goals(goals), Status::ok);
  for (int s = 0; s < model::kNumJoints; ++s) EXPECT_EQ(port.bus.goal_raw(s), 2000 + s);
}

TEST_P(BusMasterTest, SlowReadsVisitEveryServoAndAnAlertFirst) {
  for (int n = 0; n < 2 * kNumServos; ++n) master.slow_read(readings);
  for (const ServoHealth& health : readings.health) {
    EXPECT_NEAR(health.voltage_V, 12.0, 1e-6);
    EXPECT_EQ(health.temperature_C, 35);
    EXPECT_TRUE(health.torque_known);
  }
  port.bus.poke(9, 70, 1, servo_bus::xm430::kErrorOverload);
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_TRUE(readings.servo[9].alert);
  master.slow_read(readings);
  EXPECT_EQ(readings.health[9].hardware_error, servo_bus::xm430::kErrorOverload);
}

INSTANTIATE_TEST_SUITE_P(OrdinaryAndFast, BusMasterTest, ::testing::Bool(),
                         [](const auto& p) { return p.param ? "fast" : "ordinary"; });

// --- start-up ------------------------------------------------------------------------------------

class BusSetupTest : public ::testing::Test {
 protected:
  BusSetup::Progress run() {
    for (int n = 0; n < 5000; ++n) {
      clock.time += kTickPeriod;
      const auto progress = setup.step(master, clock.time);
      if (progress != BusSetup::Progress::running) return progress;
    }
    return BusSetup::Progress::running;
  }
  BusSettings settings;
  SpoiledPort port;
  StillClock clock;
  BusMaster master{settings, port, clock};
  BusSetup setup{settings};
};

TEST_F(BusSetupTest, LeavesEveryServoReadyWithTorqueOff) {
  port.bus.poke(15, 64, 1, 1);  // an arm: nobody stands on it
  ASSERT_EQ(run(), BusSetup::Progress::done);
  EXPECT_FALSE(setup.torque_found());
  for (int s = 0; s < kNumServos; ++s) {
    EXPECT_EQ(port.bus.get(s, 84, 2), 560) << servo_name(s);
    EXPECT_EQ(port.bus.get(s, 9, 1), 1) << servo_name(s);
    EXPECT_EQ(port.bus.get(s, 11, 1), 3) << servo_name(s);
    EXPECT_FALSE(port.bus.torque_on(s)) << servo_name(s);
  }
  EXPECT_EQ(port.bus.get(kNumServos, servo_bus::opencr::kServoPower, 1), 1);
  EXPECT_TRUE(master.fast_read());
}

TEST_F(BusSetupTest, WhatDiffersInTheEepromIsNamedAndNotWritten) {
  const struct {
    std::uint16_t address;
    std::int32_t value;
  } kDifferences[] = {{9, 250}, {10, 1}, {11, 4}};  // return delay, drive mode, operating mode
  for (const auto& d : kDifferences) {
    port.bus.poke(13, d.address, 1, d.value);
    ASSERT_EQ(run(), BusSetup::Progress::failed) << d.address;
    EXPECT_EQ(setup.fault(), Fault::servo_register);
    EXPECT_EQ(setup.fault_detail(), kServoIds[13]);
    EXPECT_EQ(port.bus.get(13, d.address, 1), d.value);
    port.bus.poke(13, d.address, 1, d.address == 9 ? 1 : d.address == 11 ? 3 : 0);
    setup.restart();
  }
}

TEST_F(BusSetupTest, FindsARobotThatStandsAndLeavesItsTorqueAlone) {
  for (int s = 0; s < kNumServos; ++s) {
    port.bus.poke(s, 84, 2, 800);
    port.bus.poke(s, 116, 4, 2000 + s);
    port.bus.poke(s, 9, 1, 250);  // EEPROM: refuses to be written with torque on
    port.bus.poke(s, 64, 1, 1);
  }
  ASSERT_EQ(run(), BusSetup::Progress::done);
  EXPECT_TRUE(setup.torque_found());
  for (int s = 0; s < kNumServos; ++s) {
    EXPECT_TRUE(port.bus.torque_on(s)) << servo_name(s);
    EXPECT_EQ(setup.goals_raw()[static_cast<std::size_t>(s)], 2000 + s);
    EXPECT_EQ(port.bus.get(s, 84, 2), 560) << servo_name(s);
    EXPECT_EQ(port.bus.get(s, 9, 1), 250) << servo_name(s);
  }
}

TEST_F(BusSetupTest, ALegWithoutTorqueAmongOthersIsNamedAndNothingIsSwitchedOff) {
  for (int s = 0; s < kNumServos; ++s) port.bus.poke(s, 64, 1, s == 7 ? 0 : 1);
  ASSERT_EQ(run(), BusSetup::Progress::failed);
  EXPECT_EQ(setup.fault(), Fault::torque_lost);
  EXPECT_EQ(setup.fault_detail(), kServoIds[7]);
  EXPECT_TRUE(setup.torque_found());
  for (int s = 0; s < kNumServos; ++s) EXPECT_EQ(port.bus.torque_on(s), s != 7);
}

TEST_F(BusSetupTest, OldFirmwareMeansOrdinaryReads) {
  port.bus.poke(13, 6, 1, 41);
  ASSERT_EQ(run(), BusSetup::Progress::done);
  EXPECT_FALSE(master.fast_read());
}

TEST_F(BusSetupTest, AMissingServoAndAWrongModelAreNamed) {
  port.bus.silence_from(4);
  ASSERT_EQ(run(), BusSetup::Progress::failed);
  EXPECT_EQ(setup.fault(), Fault::servo_missing);
  EXPECT_EQ(setup.fault_detail(), 15);
  setup.restart();
  port.bus.silence_from(kNumServos);
  port.bus.poke(2, 0, 2, 1060);
  ASSERT_EQ(run(), BusSetup::Progress::failed);
  EXPECT_EQ(setup.fault(), Fault::servo_model);
  EXPECT_EQ(setup.fault_detail(), 11);
}

TEST_F(BusSetupTest, AFewLostRepliesDoNotStopIt) {
  std::mt19937 random(1);
  port.spoil = [&](std::vector<std::uint8_t>& bytes) {
    if (random() % 20 == 0) bytes.clear();
  };
  EXPECT_EQ(run(), BusSetup::Progress::done);
}

/// One reading says zeros, whole and with a right CRC, as servos in the field have done.
std::vector<std::uint8_t> zeros_instead(const std::vector<std::uint8_t>& reply) {
  servo_bus::PacketParser parser;
  servo_bus::Packet packet;
  parser.feed(reply);
  EXPECT_EQ(parser.next(packet), servo_bus::ParseEvent::packet);
  const std::vector<std::uint8_t> zeros(packet.parameters.size(), 0);
  servo_bus::PacketBuffer out;
  EXPECT_EQ(servo_bus::encode_status(out, packet.id, packet.error, zeros), Status::ok);
  return {out.view().begin(), out.view().end()};
}

/// Strikes `burst` readings of registers from the `first` on; the others are as they are.
class ZeroReadings : public BusSetupTest {
 protected:
  static constexpr std::size_t kInstruction = 7;
  void strike(int first, int burst) {
    readings = 0;
    port.spoil = [=, this](std::vector<std::uint8_t>& bytes) {
      const auto what = static_cast<servo_bus::Instruction>(port.written[kInstruction]);
      if (what != servo_bus::Instruction::read) return;
      const int n = readings++;
      if ((n >= first && n < first + burst) || n == also) bytes = zeros_instead(bytes);
    };
  }
  void put_on_feet() {
    for (int s = 0; s < kNumServos; ++s) {
      port.bus.poke(s, 84, 2, 560);
      port.bus.poke(s, 116, 4, 2000 + s);
      port.bus.poke(s, 64, 1, 1);
    }
    setup.restart();
  }
  int readings = 0;
  int also = -1;  // another one that is struck
};

/// The worst pair: a leg's torque when it is looked for, and the first look at its registers.
TEST_F(ZeroReadings, OfOneLegsTorqueTwiceSwitchNothingOff) {
  settings.listen_s = settings.power_up_wait_s = 0;
  for (const int leg : {0, 5, 11})
    for (also = 20; also < 260; ++also) {
      put_on_feet();
      strike(1 + leg, 1);  // the first reading is OpenCR's
      (void)run();
      ASSERT_TRUE(port.bus.torque_on(leg)) << servo_name(leg) << " and reading " << also;
    }
}

TEST_F(ZeroReadings, OfAStandingRobotTakeNoTorqueAndMoveNoGoal) {
  settings.listen_s = settings.power_up_wait_s = 0;
  int all = 1, stopped = 0;
  for (const int burst : {1, 5})
    for (int first = 0; first < all; ++first) {
      put_on_feet();
      strike(first, burst);
      const BusSetup::Progress progress = run();
      if (burst == 1) all = std::max(all, readings);
      for (int s = 0; s < model::kNumJoints; ++s)
        ASSERT_TRUE(port.bus.torque_on(s)) << servo_name(s) << ", reading " << first;
      ASSERT_NE(progress, BusSetup::Progress::running);
      stopped += progress == BusSetup::Progress::failed ? 1 : 0;
      if (progress == BusSetup::Progress::failed) {
        ASSERT_GT(burst, 1) << "one wrong answer, reading " << first;
        ASSERT_TRUE(setup.torque_found()) << "who decides has to know that it stands";
        continue;
      }
      for (int s = 0; s < kNumServos; ++s)
        ASSERT_EQ(setup.goals_raw()[static_cast<std::size_t>(s)], 2000 + s) << "reading " << first;
    }
  EXPECT_GT(all, 200) << "all readings of a start-up have been struck";
  EXPECT_LT(stopped, all / 4);
}

TEST_F(ZeroReadings, OfARobotWithoutTorqueAreAskedAgain) {
  settings.listen_s = settings.power_up_wait_s = 0;
  int all = 1;
  for (int first = 0; first < all; ++first) {
    setup.restart();
    strike(first, 1);
    ASSERT_EQ(run(), BusSetup::Progress::done) << "reading " << first;
    all = std::max(all, readings);
  }
  EXPECT_GT(all, 200);
}

TEST_F(ZeroReadings, TheFirstWrongAnswerAfterASilenceIsTheFirst) {
  int asked = 0;
  port.spoil = [&](std::vector<std::uint8_t>& bytes) {
    constexpr std::size_t kAddress = 8;
    if (port.written[kInstruction] != static_cast<std::uint8_t>(servo_bus::Instruction::read) ||
        port.written[kAddress] != servo_bus::xm430::kReturnDelayTime.address)
      return;
    ++asked;
    if (asked <= 10) bytes.clear();
    if (asked == 11) bytes = zeros_instead(bytes);
  };
  EXPECT_EQ(run(), BusSetup::Progress::done);
  EXPECT_GT(asked, 11);
}

}  // namespace
}  // namespace sanso::firmware
