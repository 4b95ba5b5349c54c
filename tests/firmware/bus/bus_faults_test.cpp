// Replies that are whole and yet wrong, a line that never falls silent, a dead servo wherever it
// stands in the order: what the master makes of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "firmware/bus/bus_master.h"
#include "shared/servo_bus/xm430.h"

namespace sanso::firmware {
namespace {

namespace bus = servo_bus;

struct Clock : board::Clock {
  Nanoseconds now() override { return time; }
  Nanoseconds time = 0;
};

/// Answers each request with what `answer` makes of it; reading takes the time of the bytes.
struct ScriptedPort : board::SerialPort {
  explicit ScriptedPort(Clock& c) : clock(c) {}
  Status write(board::Bytes data) override {
    requests.emplace_back(data.begin(), data.end());
    const std::vector<std::uint8_t> reply = answer ? answer(requests.back()) : requests.back();
    pending.insert(pending.end(), reply.begin(), reply.end());
    return Status::ok;
  }
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override {
    if (babble) {
      clock.time += 5 * kMicrosecond;
      if (clock.time > kSecond) return Status::io_error;  // the test is lost already
      buffer[0] = static_cast<std::uint8_t>(clock.time);
      return std::size_t{1};
    }
    const std::size_t n = std::min(buffer.size(), pending.size());
    if (n == 0) clock.time = std::max(clock.time, deadline);
    std::copy_n(pending.begin(), n, buffer.begin());
    pending.erase(pending.begin(), pending.begin() + static_cast<long>(n));
    return n;
  }
  Status ready() override { return Status::ok; }

  Clock& clock;
  std::function<std::vector<std::uint8_t>(const std::vector<std::uint8_t>&)> answer;
  std::vector<std::vector<std::uint8_t>> requests;
  std::vector<std::uint8_t> pending;
  bool babble = false;
};

/// Servos at `position_raw` behind a sync read, one of them with another error and position; from
/// the first dead one on nobody speaks.
struct Servos {
  int odd_id = 0;
  std::uint8_t odd_error = 0;
  std::int32_t odd_position_raw = 2048;
  int dead_id = 0;
  bool merged = true;

  std::vector<std::uint8_t> operator()(const std::vector<std::uint8_t>& request) const {
    std::vector<std::uint8_t> out;
    const auto code = static_cast<bus::Instruction>(request[bus::kInstructionOffset]);
    const bool fast = code == bus::Instruction::fast_sync_read;
    if (!fast && code != bus::Instruction::sync_read) return out;
    bus::PacketBuffer frame;
    bus::FastStatusWriter writer;
    const std::size_t ids = request.size() - 14;
    if (fast) (void)writer.begin(frame, 1 + ids * 14);
    for (std::size_t i = 12; i + 2 < request.size(); ++i) {
      const std::uint8_t id = request[i];
      if (id == dead_id) break;
      std::array<std::uint8_t, 10> data{};
      bus::put_le(data.data() + 6, 4, id == odd_id ? odd_position_raw : 2048);
      const std::uint8_t error = id == odd_id ? odd_error : 0;
      if (fast) {
        (void)writer.append(frame, id, error, data);
      } else {
        (void)bus::encode_status(frame, id, error, data);
        out.insert(out.end(), frame.begin(), frame.end());
      }
    }
    if (fast) out.assign(frame.begin(), frame.end());
    return out;
  }
};

class BusFaults : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override { master.use_fast_read(GetParam()); }
  void read(const Servos& servos) {
    port.answer = servos;
    master.read_feedback(model::kNumJoints, readings);
  }
  Clock clock;
  ScriptedPort port{clock};
  BusMaster master{BusSettings{}, port, clock};
  ServoReadings readings;
};

constexpr int kKneeSlot = 3, kKneeId = 13;

TEST_P(BusFaults, AReplyThatSaysFailedIsNoReading) {
  read({});
  read({.odd_id = kKneeId, .odd_error = 1, .odd_position_raw = 2040});
  EXPECT_EQ(readings.answered, model::kNumJoints - 1);
  EXPECT_EQ(readings.servo[kKneeSlot].position_raw, 2048);
  EXPECT_EQ(readings.servo[kKneeSlot].age_ticks, 1);
}

TEST_P(BusFaults, AnAlertAloneIsAReading) {
  read({.odd_id = kKneeId, .odd_error = bus::kAlertBit, .odd_position_raw = 2040});
  EXPECT_EQ(readings.servo[kKneeSlot].position_raw, 2040);
  EXPECT_TRUE(readings.servo[kKneeSlot].alert);
}

TEST_P(BusFaults, AJumpThatNoJointCanMakeIsNoReadingHoweverLongItLasts) {
  read({});
  for (int k = 1; k < 300; ++k) {
    read({.odd_id = kKneeId, .odd_position_raw = 0});
    ASSERT_EQ(readings.servo[kKneeSlot].position_raw, 2048) << k;
    ASSERT_EQ(readings.servo[kKneeSlot].age_ticks, k);
  }
  read({});
  EXPECT_EQ(readings.servo[kKneeSlot].age_ticks, 0);
}

TEST_P(BusFaults, WithoutTorqueAJointThatStaysElsewhereIsBelieved) {
  read({});
  master.expect_torque(false);
  for (int k = 1; k < 5; ++k) {
    read({.odd_id = kKneeId, .odd_position_raw = 1000 + k});
    ASSERT_EQ(readings.servo[kKneeSlot].position_raw, 2048) << k;
  }
  read({.odd_id = kKneeId, .odd_position_raw = 1005});
  EXPECT_EQ(readings.servo[kKneeSlot].position_raw, 1005) << "sooner than a servo counts as silent";
  EXPECT_EQ(readings.servo[kKneeSlot].age_ticks, 0);
}

TEST_P(BusFaults, WithoutTorqueAJointThatIsElsewhereEachTimeIsNot) {
  read({});
  master.expect_torque(false);
  for (int k = 1; k < 300; ++k) {
    read({.odd_id = kKneeId, .odd_position_raw = k % 2 == 0 ? 200 : 1000});
    ASSERT_EQ(readings.servo[kKneeSlot].position_raw, 2048) << k;
  }
}

TEST_P(BusFaults, AfterATenthOfASecondOfSilenceAJointMayBeAnywhere) {
  read({});
  for (int k = 0; k < 10; ++k) read({.dead_id = kKneeId});
  read({.odd_id = kKneeId, .odd_position_raw = 1000});
  EXPECT_EQ(readings.servo[kKneeSlot].position_raw, 1000) << "it has been turned by hand";
}

TEST_P(BusFaults, APositionOutsideTheEncoderIsNoReading) {
  read({.odd_id = kKneeId, .odd_position_raw = 9000});
  EXPECT_FALSE(readings.servo[kKneeSlot].known);
}

TEST_P(BusFaults, OneDeadServoIsOneSilentServoWhicheverItIs) {
  for (std::size_t slot = 0; slot < model::kNumJoints; ++slot) {
    SCOPED_TRACE(servo_name(static_cast<int>(slot)));
    BusMaster fresh{BusSettings{}, port, clock};
    fresh.use_fast_read(GetParam());
    ServoReadings seen;
    Servos servos;
    servos.dead_id = kServoIds[slot];
    port.answer = servos;
    for (int k = 0; k < 10; ++k) fresh.read_feedback(model::kNumJoints, seen);
    for (std::size_t s = 0; s < model::kNumJoints; ++s)
      EXPECT_EQ(seen.servo[s].age_ticks >= 10, s == slot) << servo_name(static_cast<int>(s));
  }
}

TEST_P(BusFaults, ALineThatNeverFallsSilentHoldsTheTickNoLongerThanALateReply) {
  port.babble = true;
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_LT(clock.time, kTickPeriod);
}

/// What another master's noise or a flipped bit makes of the length field.
TEST_P(BusFaults, AFrameLongerThanAnyReplyHidesNothing) {
  port.answer = [](const std::vector<std::uint8_t>& request) {
    std::vector<std::uint8_t> bytes = {0xFF, 0xFF, 0xFD, 0x00, 13, 0x00, 0x03, 0x55};
    const std::vector<std::uint8_t> reply = Servos{}(request);
    bytes.insert(bytes.end(), reply.begin(), reply.end());
    return bytes;
  };
  const Nanoseconds begin = clock.time;
  master.read_feedback(model::kNumJoints, readings);
  EXPECT_EQ(readings.answered, model::kNumJoints);
  EXPECT_LT(clock.time - begin, kMillisecond) << "and nobody waits for its end";
}

/// An arm servo says alert once and is silent from then on, as after a shutdown with a broken plug.
TEST_P(BusFaults, AnAlertThatNobodyExplainsDoesNotStarveTheOthers) {
  readings.servo[14].alert = true;
  std::vector<int> asked(256, 0);
  port.answer = [&](const std::vector<std::uint8_t>& request) {
    ++asked[request[4]];
    return std::vector<std::uint8_t>{};
  };
  for (int k = 0; k < 8 * kNumServos; ++k) master.slow_read(readings);
  for (const std::uint8_t id : kServoIds) EXPECT_GE(asked[id], 2) << int{id};
}

INSTANTIATE_TEST_SUITE_P(OrdinaryAndFast, BusFaults, testing::Bool(),
                         [](const auto& p) { return p.param ? "fast" : "ordinary"; });

}  // namespace
}  // namespace sanso::firmware
