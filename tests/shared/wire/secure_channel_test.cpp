// Sealed datagrams: only the other side, only once, only in this session.
#include "shared/wire/secure_channel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "shared/wire/codec.h"

namespace sanso::wire {
namespace {

using Datagram = std::vector<std::uint8_t>;

Key test_key(std::uint8_t fill) {
  Key key;
  key.fill(fill);
  return key;
}

Datagram hello_of(SecureChannel& host, bool fresh = false) {
  Datagram d(kMaxDatagram);
  d.resize(*host.make_hello(d, fresh));
  return d;
}

Datagram seal(SecureChannel& from, std::uint32_t sequence) {
  std::array<std::uint8_t, kMaxDatagram> plain{};
  const auto size = encode(Command{sequence, CommandKind::none, 0, 0, 0}, plain);
  Datagram d(kMaxDatagram);
  const auto sealed = from.seal(std::span(plain).first(*size), d);
  EXPECT_TRUE(sealed.ok());
  d.resize(sealed.ok() ? *sealed : 0);
  return d;
}

struct Seen {
  Status status;
  std::uint32_t sequence;
  Datagram reply;
};
Seen open(SecureChannel& at, const Datagram& datagram) {
  std::array<std::uint8_t, kMaxDatagram> message{}, reply{};
  const auto opened = at.open(datagram, message, reply);
  Command command;
  if (opened.status == Status::ok) {
    EXPECT_EQ(decode(Bytes(message).first(opened.message_bytes), command), Status::ok);
  }
  return {opened.status, command.sequence,
          Datagram(reply.begin(), reply.begin() + static_cast<long>(opened.reply_bytes))};
}

struct Pair {
  SecureChannel host{Role::host, test_key(1)};
  SecureChannel controller{Role::controller, test_key(1)};
  void connect() {
    const Seen answer = open(controller, hello_of(host));
    EXPECT_EQ(open(host, answer.reply).status, Status::empty);
    EXPECT_TRUE(host.established());
    EXPECT_EQ(open(controller, seal(host, 1)).status, Status::ok);
    EXPECT_TRUE(controller.established());
  }
};

TEST(SecureChannel, MessagesPassBothWays) {
  Pair p;
  p.connect();
  EXPECT_EQ(open(p.controller, seal(p.host, 42)).sequence, 42u);
  EXPECT_EQ(open(p.host, seal(p.controller, 43)).sequence, 43u);
  EXPECT_EQ(p.host.dropped() + p.controller.dropped(), 0u);
}

TEST(SecureChannel, NothingPassesBeforeTheHandshake) {
  Pair p;
  Datagram d(kMaxDatagram);
  const Datagram plain = {kProtocolVersion, 5, 0};
  EXPECT_EQ(p.host.seal(plain, d).status(), Status::not_ready);
  EXPECT_EQ(p.controller.seal(plain, d).status(), Status::not_ready);
}

TEST(SecureChannel, TheControllerHasNoSessionBeforeTheHostHasProvedItself) {
  Pair p;
  open(p.controller, hello_of(p.host));
  EXPECT_FALSE(p.controller.established());
}

TEST(SecureChannel, AReplayedDatagramIsDropped) {
  Pair p;
  p.connect();
  const Datagram d = seal(p.host, 2);
  EXPECT_EQ(open(p.controller, d).status, Status::ok);
  EXPECT_EQ(open(p.controller, d).status, Status::stale);
  EXPECT_EQ(p.controller.dropped(), 1u);
  EXPECT_EQ(p.controller.drops().replayed, 1u);
}

TEST(SecureChannel, DatagramsMayOvertakeWithinTheWindowButNotBeyond) {
  Pair p;
  p.connect();
  const Datagram late = seal(p.host, 2);
  for (std::uint64_t i = 0; i + 1 < ReplayWindow::kSize; ++i)
    EXPECT_EQ(open(p.controller, seal(p.host, 3)).status, Status::ok);
  EXPECT_EQ(open(p.controller, late).status, Status::ok);
  const Datagram later = seal(p.host, 4);
  for (std::uint64_t i = 0; i < ReplayWindow::kSize; ++i) open(p.controller, seal(p.host, 5));
  EXPECT_EQ(open(p.controller, later).status, Status::stale);
}

TEST(SecureChannel, EveryFlippedBitIsDetected) {
  Pair p;
  p.connect();
  const Datagram good = seal(p.host, 2);
  for (std::size_t byte = 0; byte < good.size(); ++byte) {
    Datagram forged = good;
    forged[byte] ^= 0x10;
    EXPECT_NE(open(p.controller, forged).status, Status::ok) << "byte " << byte;
  }
  EXPECT_EQ(open(p.controller, good).status, Status::ok);
}

TEST(SecureChannel, EveryShorterDatagramIsDropped) {
  Pair p;
  p.connect();
  const Datagram good = seal(p.host, 2);
  for (std::size_t n = 0; n < good.size(); ++n)
    EXPECT_NE(
        open(p.controller, Datagram(good.begin(), good.begin() + static_cast<long>(n))).status,
        Status::ok);
}

TEST(SecureChannel, ADatagramSentBackAtItsSenderIsDropped) {
  Pair p;
  p.connect();
  EXPECT_EQ(open(p.host, seal(p.host, 2)).status, Status::rejected);
  EXPECT_EQ(open(p.controller, seal(p.controller, 2)).status, Status::rejected);
  EXPECT_EQ(open(p.host, hello_of(p.host)).status, Status::malformed);
}

TEST(SecureChannel, AnotherKeyOpensNothing) {
  Pair p;
  SecureChannel stranger(Role::host, test_key(2));
  EXPECT_EQ(open(p.controller, hello_of(stranger)).status, Status::rejected);
}

TEST(SecureChannel, SessionsOfSeveralHostsStandSideBySide) {
  SecureChannel controller(Role::controller, test_key(1));
  std::vector<std::unique_ptr<SecureChannel>> hosts;
  for (int i = 0; i < SecureChannel::kMaxSessions; ++i) {
    hosts.push_back(std::make_unique<SecureChannel>(Role::host, test_key(1)));
    open(*hosts.back(), open(controller, hello_of(*hosts.back())).reply);
    EXPECT_EQ(open(controller, seal(*hosts.back(), 1)).status, Status::ok);
  }
  for (int i = 0; i < SecureChannel::kMaxSessions; ++i) {
    SecureChannel& host = *hosts[static_cast<std::size_t>(i)];
    EXPECT_EQ(open(controller, seal(host, 2)).status, Status::ok);
    for (int j = 0; j < SecureChannel::kMaxSessions; ++j) {
      std::array<std::uint8_t, kMaxDatagram> plain{};
      const auto size = encode(Command{9, CommandKind::none, 0, 0, 0}, plain);
      Datagram d(kMaxDatagram);
      d.resize(*controller.seal(std::span(plain).first(*size), d, j));
      EXPECT_EQ(open(host, d).status == Status::ok, i == j) << "each with keys of its own";
    }
  }
  // no place is left until one is offered or closed
  SecureChannel late(Role::host, test_key(1));
  open(late, open(controller, hello_of(late)).reply);
  EXPECT_NE(open(controller, seal(late, 1)).status, Status::ok);
  controller.offer(2);
  EXPECT_EQ(open(controller, seal(late, 1)).status, Status::ok);
  EXPECT_NE(open(controller, seal(*hosts[2], 3)).status, Status::ok) << "its place was given away";
  EXPECT_EQ(open(controller, seal(*hosts[1], 3)).status, Status::ok);
}

TEST(SecureChannel, AReplayedHelloNeitherEndsTheSessionNorRevivesAnOldOne) {
  Pair p;
  const Datagram old_hello = hello_of(p.host);
  const Datagram answer = open(p.controller, old_hello).reply;
  open(p.host, answer);
  const Datagram old_message = seal(p.host, 2);
  EXPECT_EQ(open(p.controller, old_message).status, Status::ok);

  SecureChannel host_again(Role::host, test_key(1));
  open(host_again, open(p.controller, hello_of(host_again)).reply);
  EXPECT_EQ(open(p.controller, seal(host_again, 3)).status, Status::ok);
  p.controller.close(0);  // the old one is over

  // answered with a nonce nobody holds a key for
  EXPECT_EQ(open(p.controller, old_hello).status, Status::empty);
  EXPECT_EQ(open(p.controller, old_message).status, Status::rejected);
  EXPECT_EQ(open(p.controller, seal(host_again, 4)).sequence, 4u);
  // a replayed answer does not disturb the host
  EXPECT_EQ(open(host_again, answer).status, Status::stale);
}

/// Somebody repeats recorded hellos between the answer to a joining host and its first message.
TEST(SecureChannel, ReplayedHellosDoNotStarveAHostThatJoins) {
  SecureChannel controller(Role::controller, test_key(1));
  std::vector<Datagram> recorded;
  for (int i = 0; i < SecureChannel::kMaxPending - 1; ++i) {
    SecureChannel earlier(Role::host, test_key(1));
    recorded.push_back(hello_of(earlier));
  }
  int joined = 0;
  for (int host_number = 0; host_number < 20; ++host_number) {
    SecureChannel host(Role::host, test_key(1));
    open(host, open(controller, hello_of(host)).reply);
    for (int k = 0; k < 1000; ++k)
      open(controller, recorded[static_cast<std::size_t>(k) % recorded.size()]);
    joined += open(controller, seal(host, 1)).status == Status::ok ? 1 : 0;
    controller.close(0);
  }
  EXPECT_EQ(joined, 20);
}

TEST(SecureChannel, ALostAnswerIsRepairedByRepeatingTheHello) {
  Pair p;
  open(p.controller, hello_of(p.host));  // answer lost
  p.connect();
}

TEST(SecureChannel, AHostSurvivesARestartOfTheController) {
  Pair p;
  p.connect();
  SecureChannel controller_again(Role::controller, test_key(1));
  EXPECT_NE(open(controller_again, seal(p.host, 2)).status, Status::ok);
  open(p.host, open(controller_again, hello_of(p.host, true)).reply);
  EXPECT_EQ(open(controller_again, seal(p.host, 3)).status, Status::ok);
}

TEST(SecureChannel, KeysAreReadFromHexAndNothingElse) {
  std::vector<char> text(64, 'a');
  ASSERT_TRUE(key_from_hex(text).ok());
  EXPECT_EQ((*key_from_hex(text))[0], 0xAA);
  text.push_back('\n');
  EXPECT_TRUE(key_from_hex(text).ok());
  text.push_back('b');
  EXPECT_FALSE(key_from_hex(text).ok());
  EXPECT_FALSE(key_from_hex(std::vector<char>(64, 'g')).ok());
  EXPECT_FALSE(key_from_hex(std::vector<char>(62, 'a')).ok());
}

}  // namespace
}  // namespace sanso::wire
