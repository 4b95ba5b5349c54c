// What a start hears before its first request: another master, or a line that crackles.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "firmware/bus/bus_setup.h"
#include "shared/servo_bus/encode.h"
#include "tools/bench/instant_bus.h"

namespace sanso::firmware {
namespace {

class StillClock : public board::Clock {
 public:
  Nanoseconds now() override { return time; }
  Nanoseconds time = 0;
};

/// Servos that answer at once, and bytes that nobody has asked for.
class CracklingPort : public board::SerialPort {
 public:
  Status write(board::Bytes data) override {
    ++writes;
    return bus.write(data);
  }
  Result<std::size_t> read(board::Buffer buffer, Nanoseconds deadline) override {
    if (waiting.empty()) return bus.read(buffer, deadline);
    std::copy(waiting.begin(), waiting.end(), buffer.begin());
    return std::exchange(waiting, {}).size();
  }
  Status ready() override { return Status::ok; }

  bench::InstantBus bus;
  std::vector<std::uint8_t> waiting;
  int writes = 0;
};

class BusListen : public ::testing::Test {
 protected:
  BusSetup::Progress tick() {
    clock.time += kTickPeriod;
    return setup.step(master, clock.time);
  }
  BusSetup::Progress run() {
    for (int n = 0; n < 5000; ++n)
      if (const auto progress = tick(); progress != BusSetup::Progress::running) return progress;
    return BusSetup::Progress::running;
  }
  static std::vector<std::uint8_t> ping() {
    servo_bus::PacketBuffer packet;
    (void)servo_bus::encode_ping(packet, 3);
    return {packet.view().begin(), packet.view().end()};
  }
  BusSettings settings;
  CracklingPort port;
  StillClock clock;
  BusMaster master{settings, port, clock};
  BusSetup setup{settings};
};

TEST_F(BusListen, AnotherMasterIsFoundBeforeAnythingIsSent) {
  ASSERT_EQ(tick(), BusSetup::Progress::running);
  (void)port.bus.write(ping());  // its reply is what we hear
  EXPECT_EQ(tick(), BusSetup::Progress::failed);
  EXPECT_EQ(setup.fault(), Fault::bus_foreign);
  EXPECT_EQ(port.writes, 0);
}

/// One crackle of the line, whenever it comes and whatever byte it is, is no master.
TEST_F(BusListen, OneByteOfNoiseIsNoMaster) {
  const int ticks = static_cast<int>(settings.listen_s / to_seconds(kTickPeriod));
  for (int when = 1; when < ticks; ++when) {
    for (const int value : {0x00, 0x55, 0xfd, 0xff}) {
      setup.restart();
      for (int k = 0; k <= when; ++k) {
        if (k == when) port.waiting = {static_cast<std::uint8_t>(value)};
        ASSERT_EQ(tick(), BusSetup::Progress::running) << when;
      }
      const int before = port.writes;
      for (int k = 1; k < ticks; ++k) ASSERT_EQ(tick(), BusSetup::Progress::running);
      EXPECT_EQ(port.writes, before) << "it listens anew";
      ASSERT_EQ(run(), BusSetup::Progress::done) << when << " " << value;
    }
  }
}

/// Somebody who speaks at another rate is nothing but noise, but he does not fall silent.
TEST_F(BusListen, NoiseThatComesAgainOrIsAsLongAsAPacketIsAMaster) {
  using Bursts = std::vector<std::size_t>;
  for (const Bursts& bursts :
       {Bursts{1, 1}, Bursts{3, 0, 0, 0, 2}, Bursts{1, 0, 0, 0, 0, 0, 0, 0, 0, 1}, Bursts{10}}) {
    setup.restart();
    ASSERT_EQ(tick(), BusSetup::Progress::running);
    BusSetup::Progress progress = BusSetup::Progress::running;
    for (const std::size_t bytes : bursts) {
      ASSERT_EQ(progress, BusSetup::Progress::running);
      port.waiting.assign(bytes, 0x37);
      progress = tick();
    }
    EXPECT_EQ(progress, BusSetup::Progress::failed) << bursts.size();
    EXPECT_EQ(setup.fault(), Fault::bus_foreign);
    EXPECT_EQ(port.writes, 0);
  }
}

/// A packet that arrives in two ticks is one packet.
TEST_F(BusListen, AForeignPacketInPiecesIsCounted) {
  const std::vector<std::uint8_t> bytes = ping();
  (void)master.listen();
  port.waiting.assign(bytes.begin(), bytes.begin() + 4);
  EXPECT_EQ(master.listen().packets, 0);
  port.waiting.assign(bytes.begin() + 4, bytes.end());
  EXPECT_EQ(master.listen().packets, 1);
  EXPECT_EQ(master.foreign(), 1u);
}

}  // namespace
}  // namespace sanso::firmware
