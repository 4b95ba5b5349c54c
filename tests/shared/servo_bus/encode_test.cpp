// Packets against the bytes printed in the maker's manual and against an independent encoder's leg
// vectors.
#include "shared/servo_bus/encode.h"

#include <gtest/gtest.h>

#include <numeric>

#include "shared/servo_bus/crc16.h"
#include "shared/servo_bus/units.h"
#include "shared/servo_bus/xm430.h"
#include "tests/shared/servo_bus/hex.h"

namespace sanso::servo_bus {
namespace {

const std::vector<std::uint8_t> kLegIds{7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18};

TEST(Crc16, CheckValueOfTheStandardString) {
  const std::string text = "123456789";
  EXPECT_EQ(crc16({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}), 0xFEE8);
  EXPECT_EQ(detail::kCrcTable[1], 0x8005);
  EXPECT_EQ(detail::kCrcTable[255], 0x0202);
}

TEST(Encode, ManualExamples) {
  PacketBuffer out;
  ASSERT_EQ(encode_ping(out, 1), Status::ok);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 01 03 00 01 19 4E");
  ASSERT_EQ(encode_ping(out, kBroadcastId), Status::ok);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 FE 03 00 01 31 42");
  ASSERT_EQ(encode_read(out, 1, 132, 4), Status::ok);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15");
  ASSERT_EQ(encode_write(out, 1, 116, bytes("00 02 00 00")), Status::ok);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89");
  ASSERT_EQ(encode_sync_read(out, 132, 4, bytes("01 02")), Status::ok);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA");
  ASSERT_EQ(encode_sync_write(out, 116, 4, bytes("01 02"), bytes("96 00 00 00 AA 00 00 00")),
            Status::ok);
  EXPECT_EQ(hex(out.view()),
            "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87");
  ASSERT_EQ(
      encode(out, kBroadcastId, Instruction::bulk_read, bytes("01 90 00 02 00 02 92 00 01 00")),
      Status::ok);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05");
  ASSERT_EQ(encode_reboot(out, 7), Status::ok);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 07 03 00 08 2F 36");
}

TEST(Encode, LegVectors) {
  PacketBuffer out;
  ASSERT_EQ(encode_sync_read(out, xm430::kFeedbackAddress, xm430::kFeedbackBytes, kLegIds),
            Status::ok);
  EXPECT_EQ(hex(out.view()),
            "FF FF FD 00 FE 13 00 82 7E 00 0A 00 07 08 09 0A 0B 0C 0D 0E 0F 10 11 12 9F 0D");
  ASSERT_EQ(encode_fast_sync_read(out, xm430::kFeedbackAddress, xm430::kFeedbackBytes, kLegIds),
            Status::ok);
  EXPECT_EQ(hex(out.view()),
            "FF FF FD 00 FE 13 00 8A 7E 00 0A 00 07 08 09 0A 0B 0C 0D 0E 0F 10 11 12 3C BD");
  std::vector<std::uint8_t> gains;
  for (std::size_t i = 0; i < kLegIds.size(); ++i) gains.insert(gains.end(), {0x30, 0x02});
  ASSERT_EQ(encode_sync_write(out, xm430::kPositionPGain.address, 2, kLegIds, gains), Status::ok);
  EXPECT_EQ(
      hex(out.view()),
      "FF FF FD 00 FE 2B 00 83 54 00 02 00 07 30 02 08 30 02 09 30 02 0A 30 02 0B 30 02 0C 30 02 "
      "0D 30 02 "
      "0E 30 02 0F 30 02 10 30 02 11 30 02 12 30 02 0E C3");
}

TEST(Encode, StatusWithErrorAndAlert) {
  PacketBuffer out;
  encode_status(out, 7, 0, {});
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 07 04 00 55 00 B1 0D");
  encode_status(out, 7, static_cast<std::uint8_t>(StatusError::access), {});
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 07 04 00 55 07 A0 8D");
  encode_status(out, 7, static_cast<std::uint8_t>(StatusError::data_range) | kAlertBit, {});
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 07 04 00 55 84 A9 0E");
}

TEST(Encode, StuffsAfterEveryHeaderLikeSequence) {
  PacketBuffer out;
  std::uint8_t goal[4];
  put_le(goal, 4, -131073);
  encode_write(out, 1, 116, goal);
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 01 0A 00 03 74 00 FF FF FD FD FF 23 E5");
  encode_write(out, 1, 116, bytes("FF FF FD FD"));
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 01 0A 00 03 74 00 FF FF FD FD FD 2C 65");
  // current -1, velocity -3: the sequence straddles two registers
  encode_status(out, 8, 0, bytes("FF FF FD FF FF FF 00 08 00 00"));
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 08 0F 00 55 00 FF FF FD FD FF FF FF 00 08 00 00 7F C6");
  // current 5, velocity -1, position -3
  encode_status(out, 8, 0, bytes("05 00 FF FF FF FF FD FF FF FF"));
  EXPECT_EQ(hex(out.view()), "FF FF FD 00 08 0F 00 55 00 05 00 FF FF FF FF FD FD FF FF FF AD 62");
}

TEST(Encode, FastReplyOfThreeDevices) {
  PacketBuffer out;
  FastStatusWriter writer;
  ASSERT_EQ(writer.begin(out, 1 + 3 * 8), Status::ok);
  writer.append(out, 3, 0, bytes("A6 00 00 00"));
  writer.append(out, 7, 0, bytes("1F 08 00 00"));
  writer.append(out, 4, 0, bytes("FF 03 00 00"));
  EXPECT_EQ(
      hex(out.view()),
      "FF FF FD 00 FE 19 00 55 00 03 A6 00 00 00 84 08 00 07 1F 08 00 00 16 CA 00 04 FF 03 00 00 "
      "D1 9E");
}

TEST(Encode, ExactFitAndOneByteTooMany) {
  PacketBuffer out;
  const std::vector<std::uint8_t> fits(kMaxParameters - 2, 0x11);  // two bytes are the address
  EXPECT_EQ(encode_write(out, 1, 116, fits), Status::ok);
  EXPECT_EQ(out.size(), kMaxPacketBytes);
  const std::vector<std::uint8_t> too_long(kMaxParameters - 1, 0x11);
  EXPECT_EQ(encode_write(out, 1, 116, too_long), Status::full);
  EXPECT_TRUE(out.empty());
}

TEST(Encode, RefusesIdsThatWouldLookLikeAHeader) {
  PacketBuffer out;
  EXPECT_EQ(encode_ping(out, 0xFD), Status::out_of_range);
  EXPECT_EQ(encode_ping(out, 0xFF), Status::out_of_range);
  EXPECT_EQ(encode_sync_write(out, 116, 4, kLegIds, bytes("00")), Status::out_of_range);
}

TEST(WireTime, TenBitTimesAByte) {
  EXPECT_EQ(wire_time_ns(26 + 252 + 74, 2'000'000), 1'760'000);  // a 12-servo cycle at 2 Mbit/s
}

}  // namespace
}  // namespace sanso::servo_bus
