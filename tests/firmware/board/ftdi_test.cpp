// What is FTDI's own: divisors against the maker's table, status bytes, latency, stalls, unplug in
// the middle of a transfer.
#include <gtest/gtest.h>

#include "firmware/board/linux_clock.h"
#include "firmware/board/usb/ftdi_chip.h"
#include "firmware/board/usb/ftdi_serial.h"
#include "tests/firmware/board/fake_chip.h"

namespace sanso::board {
namespace {

using testing::FakeChip;
using ByteList = std::vector<std::uint8_t>;
constexpr std::uint16_t kFt232R = 0x0600, kFt232H = 0x0900;

TEST(FtdiDivisor, AgreesWithTheMakersTable) {
  struct Row {
    int baud;
    std::uint16_t release, value, index;
  };
  // AN232B-05 for the chips of 48 MHz; Linux ftdi_sio for those of 120 MHz
  for (const Row& row :
       {Row{57'600, kFt232R, 0xC034, 0}, Row{115'200, kFt232R, 0x001A, 0},
        Row{1'000'000, kFt232R, 0x0003, 0}, Row{2'000'000, kFt232R, 0x0001, 0},
        Row{3'000'000, kFt232R, 0x0000, 0}, Row{9'600, kFt232R, 0x4138, 0},
        Row{1'000'000, kFt232H, 0x000C, 0x0200}, Row{2'000'000, kFt232H, 0x0006, 0x0200},
        Row{3'000'000, kFt232H, 0x0004, 0x0200}, Row{4'000'000, kFt232H, 0x0003, 0x0200}}) {
    const Result<ftdi::Divisor> d = ftdi::divisor_for(row.baud, row.release);
    ASSERT_TRUE(d.ok()) << row.baud;
    EXPECT_EQ(d->value, row.value) << row.baud;
    EXPECT_EQ(d->index, row.index) << row.baud;
    EXPECT_NEAR(d->baud, row.baud, 0.01 * row.baud);
  }
}

TEST(FtdiDivisor, RefusesWhatTheChipCannotMake) {
  EXPECT_FALSE(ftdi::divisor_for(4'000'000, kFt232R).ok());
  EXPECT_FALSE(ftdi::divisor_for(2'500'000, kFt232R).ok());
  EXPECT_FALSE(ftdi::divisor_for(0, kFt232H).ok());
  EXPECT_FALSE(ftdi::divisor_for(13'000'000, kFt232H).ok());
}

TEST(FtdiPackets, EveryPacketLosesItsTwoStatusBytes) {
  ByteList transfer;
  for (int packet = 0; packet < 3; ++packet) {
    const std::size_t payload = packet < 2 ? 62 : 5;
    transfer.insert(transfer.end(), {0x01, static_cast<std::uint8_t>(packet == 1 ? 0x08 : 0x60)});
    transfer.insert(transfer.end(), payload, static_cast<std::uint8_t>(packet + 1));
  }
  std::uint32_t errors = 0;
  const std::size_t n = ftdi::strip_status(transfer, 64, errors);
  ASSERT_EQ(n, 129u);
  EXPECT_EQ(transfer[61], 1);
  EXPECT_EQ(transfer[62], 2);
  EXPECT_EQ(transfer[128], 3);
  EXPECT_EQ(errors, 1u) << "one packet says framing error";
}

TEST(FtdiPackets, ShortAndEmptyPacketsCarryNothing) {
  std::uint32_t errors = 0;
  ByteList one{0x01}, two{0x01, 0x60}, none;
  EXPECT_EQ(ftdi::strip_status(one, 64, errors), 0u);
  EXPECT_EQ(ftdi::strip_status(two, 64, errors), 0u);
  EXPECT_EQ(ftdi::strip_status(none, 64, errors), 0u);
}

struct Rig {
  FakeChip chip;
  FtdiSerial port{chip, {0x0403, 0x6014, "", 0}, 2'000'000, 0};
  LinuxClock clock;
  std::string message;
  std::array<std::uint8_t, 256> buffer{};
  Result<std::size_t> read() { return port.read(buffer, clock.now() + 60 * kSecond); }
};

TEST(FtdiSerial, SetsTheLineUpAndReadsTheLatencyBack) {
  Rig rig;
  ASSERT_EQ(rig.port.open(rig.message), Status::ok) << rig.message;
  EXPECT_EQ(rig.chip.latency, 1);
  EXPECT_EQ(rig.chip.requests[3], (std::pair<std::uint16_t, std::uint16_t>{6, 0x0200}));
  EXPECT_EQ(rig.chip.requests[4].first, 8) << "8 data bits, no parity, 1 stop bit";
  EXPECT_EQ(rig.chip.requests[2].first, 0) << "no flow control";
}

TEST(FtdiSerial, AChipThatKeepsItsLatencyIsRefused) {
  Rig rig;
  rig.chip.keeps_latency = true;
  EXPECT_EQ(rig.port.open(rig.message), Status::io_error);
  EXPECT_NE(rig.message.find("latency timer is 16 ms, expected 1"), std::string::npos);
}

TEST(FtdiSerial, AnotherSerialNumberIsAnotherDevice) {
  Rig rig;
  FtdiSerial other(rig.chip, {0x0403, 0x6014, "FT2", 0}, 2'000'000, 0);
  EXPECT_EQ(other.open(rig.message), Status::io_error);
  FtdiSerial same(rig.chip, {0x0403, 0x6014, "FT1", 0}, 2'000'000, 0);
  EXPECT_EQ(same.open(rig.message), Status::ok);
}

TEST(FtdiSerial, KeepsAtLeastTwoReadsInFlight) {
  Rig rig;
  ASSERT_EQ(rig.port.open(rig.message), Status::ok);
  rig.chip.receive_serial(ByteList{7});
  ASSERT_TRUE(rig.read().ok());
  EXPECT_TRUE(rig.chip.wait_for([&] { return rig.chip.most_reads >= 2; }));
}

TEST(FtdiSerial, TransfersOfStatusAloneAreNoBytes) {
  Rig rig;
  ASSERT_EQ(rig.port.open(rig.message), Status::ok);
  for (int i = 0; i < 50; ++i) rig.chip.receive_serial({});
  rig.chip.receive_serial(ByteList{0x42});
  const Result<std::size_t> n = rig.read();
  ASSERT_TRUE(n.ok());
  EXPECT_EQ(*n, 1u);
  EXPECT_EQ(rig.buffer[0], 0x42);
}

TEST(FtdiSerial, AStallIsClearedAndTheBytesGoOn) {
  Rig rig;
  ASSERT_EQ(rig.port.open(rig.message), Status::ok);
  rig.chip.stall(3);
  ASSERT_TRUE(rig.chip.wait_for([&] { return rig.chip.stalls == 0; }));
  rig.chip.receive_serial(ByteList{9});
  ASSERT_TRUE(rig.read().ok());
  EXPECT_EQ(rig.buffer[0], 9);
  EXPECT_EQ(rig.chip.cleared, 3);
}

TEST(FtdiSerial, EndlessStallsAreADeviceThatIsGone) {
  Rig rig;
  ASSERT_EQ(rig.port.open(rig.message), Status::ok);
  rig.chip.stall(1'000'000);
  EXPECT_EQ(rig.read().status(), Status::io_error);
}

TEST(FtdiSerial, WhatCameBeforeTheUnplugIsStillDelivered) {
  Rig rig;
  ASSERT_EQ(rig.port.open(rig.message), Status::ok);
  ASSERT_TRUE(rig.chip.wait_for([&] { return rig.chip.most_reads == UsbLine::kReads; }));
  rig.chip.receive_serial(ByteList{1, 2, 3});
  rig.chip.unplug();
  const Result<std::size_t> n = rig.read();
  ASSERT_TRUE(n.ok());
  EXPECT_EQ(*n, 3u);
  EXPECT_EQ(rig.read().status(), Status::io_error);
}

TEST(FtdiSerial, AShortWriteGoesOnWhereItEnded) {
  Rig rig;
  rig.chip.largest_write = 7;
  ASSERT_EQ(rig.port.open(rig.message), Status::ok);
  ByteList bytes(100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  ASSERT_EQ(rig.port.write(bytes), Status::ok);
  ASSERT_TRUE(rig.chip.wait_for([&] { return rig.chip.sent.size() >= bytes.size(); }));
  EXPECT_EQ(rig.chip.sent_serial(), bytes);
}

}  // namespace
}  // namespace sanso::board
