// The parser on good bytes, on pieces of them, and on bytes that are not packets.
#include "shared/servo_bus/parser.h"

#include <gtest/gtest.h>

#include <random>

#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/xm430.h"
#include "tests/shared/servo_bus/hex.h"

namespace sanso::servo_bus {
namespace {

constexpr char kPositionReply[] = "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0";

TEST(Parser, ReadsAStatus) {
  PacketParser parser;
  parser.feed(bytes(kPositionReply));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  EXPECT_EQ(packet.id, 1);
  EXPECT_TRUE(packet.is_status());
  EXPECT_EQ(packet.error, 0);
  EXPECT_EQ(get_i32(packet.parameters.view()), 166);
  EXPECT_EQ(hex(parser.frame()), kPositionReply);
  EXPECT_EQ(parser.next(packet), ParseEvent::none);
  EXPECT_EQ(parser.garbage_bytes(), 0u);
}

TEST(Parser, OneByteAtATime) {
  PacketParser parser;
  Packet packet;
  const auto reply = bytes(kPositionReply);
  for (std::size_t i = 0; i + 1 < reply.size(); ++i) {
    parser.feed({&reply[i], 1});
    ASSERT_EQ(parser.next(packet), ParseEvent::none) << "after byte " << i;
  }
  parser.feed({&reply.back(), 1});
  EXPECT_EQ(parser.next(packet), ParseEvent::packet);
}

TEST(Parser, RemovesStuffing) {
  PacketParser parser;
  parser.feed(bytes("FF FF FD 00 08 0F 00 55 00 FF FF FD FD FF FF FF 00 08 00 00 7F C6"));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  const auto feedback = xm430::decode_feedback(packet.parameters.view());
  EXPECT_EQ(feedback.current_raw, -1);
  EXPECT_EQ(feedback.velocity_raw, -3);
  EXPECT_EQ(feedback.position_raw, 2048);
}

TEST(Parser, KeepsDataThatOnlyLooksStuffed) {
  PacketParser parser;
  parser.feed(bytes("FF FF FD 00 01 0A 00 03 74 00 FF FF FD FD FD 2C 65"));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  EXPECT_EQ(hex(packet.parameters.view()), "74 00 FF FF FD FD");
}

/// No instruction is FF, but a foreign master may send one: both sides count it alike.
TEST(Parser, AnInstructionOfOnesIsPartOfWhatIsStuffed) {
  PacketBuffer wire;
  const std::uint8_t data[] = {0xFF, 0xFD, 0x00, 0x0C};
  ASSERT_EQ(encode(wire, 1, static_cast<Instruction>(0xFF), data), Status::ok);
  PacketParser parser;
  parser.feed(wire.view());
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  EXPECT_EQ(hex(packet.parameters.view()), "FF FD 00 0C");
}

TEST(Parser, FindsThePacketBehindGarbage) {
  PacketParser parser;
  parser.feed(bytes("00 FF FF FF FD FD 12 FF FF FD FF"));
  parser.feed(bytes(kPositionReply));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  EXPECT_EQ(get_i32(packet.parameters.view()), 166);
  EXPECT_EQ(parser.garbage_bytes(), 11u);
}

TEST(Parser, DamagedFrameIsReportedAndTheNextOneRead) {
  auto damaged = bytes(kPositionReply);
  damaged[9] ^= 0x10;
  PacketParser parser;
  parser.feed(damaged);
  parser.feed(bytes(kPositionReply));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::crc_error);
  EXPECT_EQ(packet.id, 1);
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  EXPECT_EQ(get_i32(packet.parameters.view()), 166);
  EXPECT_EQ(parser.crc_errors(), 1u);
}

TEST(Parser, AbsurdLengthDoesNotSwallowTheNextPacket) {
  PacketParser parser;
  parser.set_max_frame(64);
  parser.feed(bytes("FF FF FD 00 01 FF 03 55 00"));
  parser.feed(bytes(kPositionReply));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  EXPECT_EQ(get_i32(packet.parameters.view()), 166);
}

TEST(Parser, StatusWithoutDataIsAPacketWithAnError) {
  PacketParser parser;
  parser.feed(bytes("FF FF FD 00 07 04 00 55 84 A9 0E"));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  EXPECT_TRUE(packet.alert());
  EXPECT_EQ(packet.status_error(), StatusError::data_range);
  EXPECT_TRUE(packet.parameters.empty());
}

TEST(FastReply, BlocksOfThreeDevices) {
  PacketParser parser;
  parser.feed(
      bytes("FF FF FD 00 FE 14 00 55 00 03 A6 00 00 00 67 A4 00 07 A5 01 24 74 00 04 1F D9 C1"));
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::packet);
  FastReplyReader reader(parser.frame());
  const std::size_t lengths[] = {4, 2, 1};
  const int ids[] = {3, 7, 4}, values[] = {166, 421, 31};
  for (int i = 0; i < 3; ++i) {
    const auto block = reader.next(lengths[i]);
    ASSERT_TRUE(block.ok());
    EXPECT_EQ(block->id, ids[i]);
    std::uint8_t wide[4] = {};
    std::copy(block->data.begin(), block->data.end(), wide);
    EXPECT_EQ(get_i32(wide), values[i]);
  }
  EXPECT_EQ(reader.next(1).status(), Status::empty);
}

TEST(FastReply, DevicesBeforeAGapAreUsable) {
  // third is missing
  auto reply = bytes("FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA");
  PacketParser parser;
  parser.feed(reply);
  Packet packet;
  ASSERT_EQ(parser.next(packet), ParseEvent::none);
  FastReplyReader reader(parser.pending());
  EXPECT_TRUE(reader.next(4).ok());
  EXPECT_TRUE(reader.next(4).ok());
  EXPECT_EQ(reader.next(4).status(), Status::empty);
}

TEST(FastReply, DamageStopsTheChain) {
  auto reply = bytes(
      "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 09 00 00 16 CA 00 04 FF 03 00 00 "
      "D1 9E");
  FastReplyReader reader(reply);
  EXPECT_TRUE(reader.next(4).ok());
  EXPECT_EQ(reader.next(4).status(), Status::malformed);
  EXPECT_EQ(reader.next(4).status(), Status::malformed);
}

TEST(Parser, RandomPacketsInRandomPiecesBetweenNoiseRoundTrip) {
  constexpr unsigned kSeed = 1234;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random(kSeed);
  const std::uint8_t likely[] = {0xFF, 0xFF, 0xFD, 0x00, 0x55, 0x03};
  PacketParser parser;
  for (int round = 0; round < 2000; ++round) {
    std::vector<std::uint8_t> data(random() % 60);
    for (auto& byte : data)
      byte = random() % 3 ? likely[random() % 6] : static_cast<std::uint8_t>(random());
    PacketBuffer wire;
    ASSERT_EQ(encode_status(wire, random() % 253, static_cast<std::uint8_t>(random()), data),
              Status::ok);
    const std::uint8_t noise[] = {0x12, 0xFF, 0x7F};
    parser.feed({noise, random() % 4});
    Packet packet;
    ParseEvent event = ParseEvent::none;
    for (std::size_t i = 0; i < wire.size();) {
      const std::size_t piece = std::min<std::size_t>(1 + random() % 9, wire.size() - i);
      parser.feed(wire.view().subspan(i, piece));
      i += piece;
      event = parser.next(packet);
      if (i < wire.size()) {
        ASSERT_EQ(event, ParseEvent::none);
      }
    }
    ASSERT_EQ(event, ParseEvent::packet) << "round " << round;
    EXPECT_EQ(hex(packet.parameters.view()), hex(data));
  }
}

}  // namespace
}  // namespace sanso::servo_bus
