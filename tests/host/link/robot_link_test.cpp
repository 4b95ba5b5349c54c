// RobotLink against a controller made of the shared wire code, over a path that loses, repeats and
// swaps datagrams.
#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <random>

#include "host/link/robot_link.h"
#include "host/link/udp_channel.h"
#include "shared/policy/policy_bytes.h"
#include "shared/wire/codec.h"
#include "shared/wire/upload.h"

namespace sanso::link {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Drops, doubles and swaps datagrams with the same probability each.
struct BadPath {
  std::mt19937 rng{99};
  double trouble = 0.0;
  std::deque<Bytes> queue;
  void push(const std::uint8_t* data, std::size_t size) {
    std::uniform_real_distribution<double> u(0, 1);
    if (u(rng) < trouble) return;
    queue.emplace_back(data, data + size);
    if (u(rng) < trouble) queue.push_back(queue.back());
    if (u(rng) < trouble && queue.size() > 1) std::swap(queue.back(), queue[queue.size() - 2]);
  }
  std::size_t pop(std::uint8_t* buffer) {
    if (queue.empty()) return 0;
    const std::size_t n = queue.front().size();
    std::copy(queue.front().begin(), queue.front().end(), buffer);
    queue.pop_front();
    return n;
  }
};

/// Answers as a controller does, every 10 ms.
struct FakeController {
  wire::SecureChannel secure;
  std::unique_ptr<wire::FixedUploadAssembler<policy::kMaxMiddleBytes>> assembler =
      std::make_unique<wire::FixedUploadAssembler<policy::kMaxMiddleBytes>>();
  BadPath to_host, to_controller;
  std::uint64_t tick = 0;
  std::uint32_t executed = 0, last_sequence = 0;
  bool refuse = false;
  Bytes received;
  explicit FakeController(const wire::Key& key) : secure(wire::Role::controller, key) {}

  template <class M>
  void send(const M& m) {
    std::array<std::uint8_t, wire::kMaxDatagram> plain, sealed;
    const auto n = wire::encode(m, plain);
    ASSERT_TRUE(n.ok());
    const auto s = secure.seal(std::span(plain).first(*n), sealed);
    if (s.ok()) to_host.push(sealed.data(), *s);
  }
  void take(std::span<const std::uint8_t> message) {
    const auto type = wire::message_type(message);
    wire::Command c;
    wire::UploadChunk chunk;
    if (*type == wire::MessageType::command && wire::decode(message, c) == Status::ok) {
      if (c.sequence > last_sequence) ++executed, last_sequence = c.sequence;
      wire::CommandAck ack;
      ack.sequence = c.sequence;
      ack.accepted = !refuse;
      ack.reason = refuse ? 7 : 0;
      send(ack);
    } else if (*type == wire::MessageType::upload_chunk &&
               wire::decode(message, chunk) == Status::ok) {
      (void)(*assembler)->accept(chunk);
      wire::UploadAck ack;
      ack.kind = chunk.kind;
      ack.upload_id = chunk.upload_id;
      ack.complete = (*assembler)->complete();
      ack.first_missing = (*assembler)->first_missing();
      if (ack.complete) received.assign((*assembler)->blob().begin(), (*assembler)->blob().end());
      send(ack);
    }
  }
  void step() {
    ++tick;
    std::array<std::uint8_t, wire::kMaxDatagram> in, message, reply;
    for (std::size_t n = to_controller.pop(in.data()); n > 0; n = to_controller.pop(in.data())) {
      const auto opened = secure.open(std::span(in).first(n), message, reply);
      if (opened.reply_bytes > 0) to_host.push(reply.data(), opened.reply_bytes);
      if (opened.status == Status::ok) take(std::span(message).first(opened.message_bytes));
    }
    wire::Observation o;
    o.tick = tick;
    send(o);
  }
};

struct TestPath : DatagramChannel, HostClock {
  FakeController& controller;
  Nanoseconds time = 0;
  explicit TestPath(FakeController& c) : controller(c) {}
  bool send(const std::uint8_t* data, std::size_t size) override {
    controller.to_controller.push(data, size);
    return true;
  }
  std::size_t receive(std::uint8_t* buffer, std::size_t) override {
    return controller.to_host.pop(buffer);
  }
  Nanoseconds now() override { return time; }
  void wait_until(Nanoseconds) override {
    time += kTickPeriod;
    controller.step();
  }
  void finish_computation(Nanoseconds, Nanoseconds) override {}
};

struct Link : testing::Test {
  wire::Key key = wire::random_key();
  FakeController controller{key};
  TestPath path{controller};
  RobotLink link{path, path, key};
};

TEST_F(Link, OpensAndSeesObservations) {
  ASSERT_EQ(link.open(), Status::ok);
  EXPECT_GT(link.latest().tick, 0u);
  link.take_observations();
  const std::uint64_t before = link.latest().tick;
  for (int i = 0; i < 5; ++i) link.wait_observation(path.now() + kSecond);
  EXPECT_EQ(link.latest().tick, before + 5);
  EXPECT_EQ(link.take_observations().size(), 5u);
}

TEST_F(Link, AnotherKeyTimesOut) {
  RobotLink stranger(path, path, wire::random_key());
  EXPECT_EQ(stranger.open(), Status::timeout);
  EXPECT_GT(controller.secure.dropped(), 0u);
}

TEST_F(Link, ACommandIsCarriedOutOnceOverABadPath) {
  controller.to_host.trouble = controller.to_controller.trouble = 0.3;
  ASSERT_EQ(link.open(), Status::ok);
  const std::uint32_t before = controller.executed;
  for (int i = 0; i < 20; ++i)
    ASSERT_EQ(link.command({.kind = wire::CommandKind::arm}), Status::ok);
  EXPECT_EQ(controller.executed - before, 20u);
}

TEST_F(Link, ARefusedCommandTellsTheReason) {
  ASSERT_EQ(link.open(), Status::ok);
  controller.refuse = true;
  EXPECT_EQ(link.command({.kind = wire::CommandKind::arm}), Status::rejected);
  EXPECT_EQ(link.refusal(), 7);
}

TEST_F(Link, AMiddleTableArrivesWholeOverABadPath) {
  controller.to_host.trouble = controller.to_controller.trouble = 0.2;
  ASSERT_EQ(link.open(), Status::ok);
  auto table = std::make_unique<policy::MiddleTable>();
  for (int i = 0; i < 80; ++i) {
    policy::Knot knot;
    knot.u.setConstant(0.01 * i);
    table->knots.try_push(knot);
  }
  ASSERT_EQ(link.upload(*table), Status::ok);
  auto received = std::make_unique<policy::MiddleTable>();
  ASSERT_EQ(policy::from_bytes(controller.received, *received), Status::ok);
  ASSERT_EQ(received->knots.size(), 80u);
  EXPECT_FLOAT_EQ(received->knots[79].u[3], 0.79f);
}

TEST_F(Link, SilenceEndsInATimeout) {
  ASSERT_EQ(link.open(), Status::ok);
  controller.to_controller.trouble = 1.0;
  EXPECT_EQ(link.command({.kind = wire::CommandKind::stop}), Status::timeout);
}

TEST(UdpChannel, AddressesAreChecked) {
  EXPECT_THROW(UdpChannel("nohost"), std::runtime_error);
  EXPECT_THROW(UdpChannel("127.0.0.1:"), std::runtime_error);
  UdpChannel channel("127.0.0.1:9");
  std::uint8_t byte = 0;
  EXPECT_EQ(channel.receive(&byte, 1), 0u);
}

}  // namespace
}  // namespace sanso::link
