// Whose orders count: one owner with a lease, others watch; commands that were long on their way
// are refused; an emergency stop never is.
#include "firmware/link/link.h"

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <vector>

#include "shared/wire/codec.h"

namespace sanso::firmware {
namespace {

using Bytes = std::vector<std::uint8_t>;
using wire::CommandKind;

struct Clock : board::Clock {
  Nanoseconds now() override { return time; }
  Nanoseconds time = kSecond;
};

struct Network : board::Datagram {
  struct Item {
    Bytes bytes;
    board::Peer peer;
  };
  Status send(board::Bytes data, const board::Peer& to) override {
    out.push_back({{data.begin(), data.end()}, to});
    return Status::ok;
  }
  Result<std::size_t> receive(board::Buffer buffer, board::Peer& from, Nanoseconds) override {
    if (in.empty()) return std::size_t{0};
    const Item item = in.front();
    in.pop_front();
    from = item.peer;
    std::copy(item.bytes.begin(), item.bytes.end(), buffer.begin());
    return item.bytes.size();
  }
  std::deque<Item> in, out;
};

struct LinkTest : testing::Test {
  wire::Key key{1, 2, 3};
  Clock clock;
  Network network;
  std::unique_ptr<Handover> handover = std::make_unique<Handover>();
  std::unique_ptr<Link> link = std::make_unique<Link>(key, network, clock, *handover, "robot one");
  std::uint64_t tick = 0;

  /// A program that holds the key, at an address of its own.
  struct Host {
    wire::SecureChannel channel;
    board::Peer peer;
    std::vector<wire::CommandAck> acks;
    std::vector<wire::UploadAck> upload_acks;
    int observations = 0;
    std::optional<wire::Identity> identity;
    Host(const wire::Key& key, std::uint8_t address) : channel(wire::Role::host, key) {
      peer.size = 1;
      peer.bytes[0] = address;
    }
  };

  void send(Host& host, Bytes bytes) { network.in.push_back({std::move(bytes), host.peer}); }
  template <class Message>
  Bytes seal(Host& host, const Message& message) {
    std::array<std::uint8_t, wire::kMaxDatagram> plain{}, sealed{};
    const auto n = wire::encode(message, plain);
    const auto m = host.channel.seal(std::span(plain).first(*n), sealed);
    EXPECT_TRUE(m.ok());
    return Bytes(sealed.begin(), sealed.begin() + static_cast<long>(*m));
  }
  /// One tick of the controller, which accepts everything; every host reads its datagrams.
  void run(std::initializer_list<Host*> hosts) {
    clock.time += kTickPeriod;
    link->poll(0);
    wire::Observation o;
    o.tick = ++tick;
    handover->observations.push(o);
    wire::Command command;
    while (handover->commands.pop(command)) {
      executed.push_back(command.kind);
      handover->acks.push({command.sequence, 1, wire::SupervisorState::idle, 0});
    }
    link->poll(0);
    for (const Network::Item& item : network.out)
      for (Host* host : hosts)
        if (host->peer.bytes[0] == item.peer.bytes[0]) take(*host, item.bytes);
    network.out.clear();
  }
  static void take(Host& host, const Bytes& bytes) {
    std::array<std::uint8_t, wire::kMaxDatagram> message{}, reply{};
    if (wire::Identity identity; wire::decode_identity(bytes, identity) == Status::ok)
      host.identity = identity;
    const auto opened = host.channel.open(bytes, message, reply);
    if (opened.status != Status::ok) return;
    const auto whole = std::span(message).first(opened.message_bytes);
    wire::Observation o;
    wire::CommandAck ack;
    wire::UploadAck upload_ack;
    if (wire::decode(whole, o) == Status::ok) ++host.observations;
    if (wire::decode(whole, ack) == Status::ok) host.acks.push_back(ack);
    if (wire::decode(whole, upload_ack) == Status::ok) host.upload_acks.push_back(upload_ack);
  }
  void join(Host& host) {
    Bytes hello(wire::kMaxDatagram);
    hello.resize(*host.channel.make_hello(hello, true));
    send(host, hello);
    run({&host});
    order(host, CommandKind::none);
    run({&host});
  }
  void order(Host& host, CommandKind kind, std::uint64_t age_ticks = 0) {
    send(host, seal(host, wire::Command{++sequence, kind, 1, policy::LayerSwitches::kAll, 0,
                                        tick > age_ticks ? tick - age_ticks : 0}));
  }
  std::uint32_t sequence = 0;
  std::vector<CommandKind> executed;
};

TEST_F(LinkTest, TheFirstHostThatOrdersOwnsTheRobotAndTheOtherWatches) {
  Host owner(key, 1), watcher(key, 2);
  join(watcher);
  join(owner);
  order(owner, CommandKind::arm);
  order(watcher, CommandKind::stop);
  run({&owner, &watcher});
  EXPECT_EQ(executed, std::vector{CommandKind::arm});
  ASSERT_FALSE(watcher.acks.empty());
  EXPECT_EQ(watcher.acks.back().accepted, 0);
  EXPECT_EQ(watcher.acks.back().reason, static_cast<int>(Refusal::not_owner));
  const int before = watcher.observations, before_owner = owner.observations;
  run({&owner, &watcher});
  EXPECT_EQ(watcher.observations, before + 1) << "it sees all the same";
  EXPECT_EQ(owner.observations, before_owner + 1) << "and the owner is undisturbed";
  wire::UploadChunk chunk;
  chunk.upload_id = 5;
  chunk.count = 1;
  send(watcher, seal(watcher, chunk));
  run({&owner, &watcher});
  for (const wire::UploadAck& ack : watcher.upload_acks)
    EXPECT_EQ(ack.reason, static_cast<int>(Refusal::not_owner));
}

TEST_F(LinkTest, WhoeverOnlyLooksIsNeverInTheWayOfOneWhoOrders) {
  Host watcher(key, 1), owner(key, 2);
  join(watcher);
  for (int i = 0; i < 300; ++i) {
    if (i % 10 == 0) order(watcher, CommandKind::none);
    if (i % 70 == 0) order(watcher, CommandKind::emergency_stop);
    run({&watcher});
  }
  join(owner);
  order(watcher, CommandKind::none);
  order(owner, CommandKind::arm);
  run({&watcher, &owner});
  EXPECT_EQ(executed, std::vector{CommandKind::arm});
  order(watcher, CommandKind::lower);
  run({&watcher, &owner});
  EXPECT_EQ(executed.size(), 1u) << "now it is owned";
  EXPECT_EQ(watcher.acks.back().reason, static_cast<int>(Refusal::not_owner));
  for (int i = 0; i < 220; ++i) {  // the owner looks on, the watcher is gone
    if (i % 10 == 0) order(owner, CommandKind::none);
    run({&owner});
  }
  Host late(key, 3);
  join(late);
  order(late, CommandKind::lower);
  run({&late});
  EXPECT_EQ(executed.size(), 1u) << "an owner that has ordered once keeps the robot";
}

TEST_F(LinkTest, AnUploadIsAnOrderToo) {
  Host watcher(key, 1), owner(key, 2);
  join(watcher);
  join(owner);
  const std::vector<std::uint8_t> blob(3000, 7);
  send(owner, seal(owner, wire::make_chunk(wire::UploadKind::primitives, 5, blob, 1, 0)));
  run({&watcher, &owner});
  ASSERT_FALSE(owner.upload_acks.empty());
  EXPECT_EQ(owner.upload_acks.back().refused, 0);
  order(watcher, CommandKind::lower);
  run({&watcher, &owner});
  EXPECT_TRUE(executed.empty());
}

TEST_F(LinkTest, AHostThatWaitsForTheSelfTestHearsOfItsEnd) {
  Host owner(key, 1);
  join(owner);
  const int before = owner.observations;
  for (int i = 0; i < 500; ++i) run({&owner});
  EXPECT_EQ(owner.observations, before + 500);
}

TEST_F(LinkTest, AWatcherTakesOverWhenTheOwnersLeaseHasRunOut) {
  Host owner(key, 1), watcher(key, 2);
  join(owner);
  join(watcher);
  order(owner, CommandKind::arm);
  run({&owner, &watcher});
  executed.clear();
  for (int i = 0; i < 150; ++i) {  // the watcher is alive, the owner is not
    if (i % 10 == 0) order(watcher, CommandKind::none);
    run({&owner, &watcher});
  }
  order(watcher, CommandKind::lower);
  run({&owner, &watcher});
  EXPECT_TRUE(executed.empty()) << "not yet";
  for (int i = 0; i < 60; ++i) run({&owner, &watcher});
  order(watcher, CommandKind::lower);
  run({&owner, &watcher});
  EXPECT_EQ(executed, std::vector{CommandKind::lower});
  order(owner, CommandKind::arm);
  run({&owner, &watcher});
  EXPECT_EQ(executed.size(), 1u) << "the old owner watches now";
}

TEST_F(LinkTest, OnlyTheOwnersDatagramsCountAsTheHostBeingThere) {
  Host owner(key, 1), watcher(key, 2);
  join(owner);
  order(owner, CommandKind::arm);
  run({&owner});
  join(watcher);
  const Nanoseconds heard = handover->host_heard.load();
  for (int i = 0; i < 20; ++i) {
    order(watcher, CommandKind::none);
    run({&owner, &watcher});
  }
  EXPECT_LE(handover->host_heard.load(), heard);
}

TEST_F(LinkTest, AProgramThatStartsAgainAtTheSameAddressKeepsTheRobot) {
  Host owner(key, 1), again(key, 1), other(key, 2);
  join(owner);
  order(owner, CommandKind::arm);
  run({&owner});
  join(again);
  join(other);
  order(other, CommandKind::disarm);
  order(again, CommandKind::stop);
  run({&again, &other});
  EXPECT_EQ(executed, (std::vector{CommandKind::arm, CommandKind::stop}));
}

TEST_F(LinkTest, ACommandThatWasLongOnItsWayIsRefused) {
  Host owner(key, 1);
  join(owner);
  for (int i = 0; i < 100; ++i) run({&owner});
  for (const CommandKind kind : {CommandKind::arm, CommandKind::disarm, CommandKind::stop}) {
    order(owner, kind, wire::kCommandLife_ticks + 1);
    run({&owner});
    EXPECT_EQ(owner.acks.back().reason, static_cast<int>(Refusal::stale_command));
  }
  EXPECT_TRUE(executed.empty());
  order(owner, CommandKind::arm, wire::kCommandLife_ticks - 2);
  run({&owner});
  EXPECT_EQ(executed.size(), 1u);
}

TEST_F(LinkTest, AnEmergencyStopIsTakenFromEverybodyHoweverOld) {
  Host owner(key, 1), watcher(key, 2);
  join(owner);
  join(watcher);
  for (int i = 0; i < 100; ++i) run({&owner, &watcher});
  order(watcher, CommandKind::emergency_stop, 90);
  run({&owner, &watcher});
  EXPECT_TRUE(handover->emergency_stop);
  EXPECT_EQ(watcher.acks.back().accepted, 1);
}

TEST_F(LinkTest, SaysWhoItIsToAnyVersionAndToNobodyMore) {
  Host stranger({9}, 3);
  Bytes who(wire::kIdentityBytes);
  wire::encode_who(std::span<std::uint8_t, wire::kIdentityBytes>(who));
  who[0] = 99;
  send(stranger, who);
  run({&stranger});
  ASSERT_TRUE(stranger.identity.has_value());
  EXPECT_STREQ(stranger.identity->robot_name.data(), "robot one");
  EXPECT_EQ(stranger.identity->protocol_version, wire::kProtocolVersion);
  EXPECT_EQ(stranger.observations, 0);
}

TEST_F(LinkTest, DropsAreCountedByReason) {
  Host owner(key, 1), stranger({9}, 3);
  join(owner);
  const Bytes good = seal(owner, wire::Command{});
  Bytes old_version = good, damaged = good;
  old_version[0] = 1;
  damaged.back() ^= 1;
  Bytes foreign_hello(wire::kMaxDatagram);
  foreign_hello.resize(*stranger.channel.make_hello(foreign_hello, true));
  for (const Bytes& bytes : {good, good, old_version, damaged, foreign_hello, Bytes{2, 2}})
    send(owner, bytes);
  run({&owner});
  EXPECT_EQ(link->drops().replayed, 1u);
  EXPECT_EQ(link->drops().version, 1u);
  EXPECT_EQ(link->drops().forged, 2u);
  EXPECT_EQ(link->drops().malformed, 1u);
}

}  // namespace
}  // namespace sanso::firmware
