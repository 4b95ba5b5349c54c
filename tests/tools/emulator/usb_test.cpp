// The emulated USB devices as a kernel sees them: by the USB/IP protocol on a socket pair, with
// headers that are written here byte by byte.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tools/emulator/usb/ftdi_function.h"
#include "tools/emulator/usb/hid_function.h"
#include "tools/emulator/usb/usbip_plug.h"
#include "tools/plant/world.h"

namespace sanso::emulator {
namespace {

constexpr std::int32_t kPending = 1;  // no reply came

/// A kernel's end of the line.
class Kernel {
 public:
  explicit Kernel(UsbFunction& function) : plug_(function) {
    int pair[2] = {-1, -1};
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair), 0);
    plug_.serve_on(FileDescriptor(pair[0]));
    line_ = FileDescriptor(pair[1]);
  }
  struct Reply {
    std::uint32_t command = 0, sequence = 0;
    std::int32_t status = kPending;
    UsbBytes data;
  };
  void serve(Nanoseconds now) { plug_.serve(now); }
  /// The next message from the device, if there is one.
  Reply reply() {
    Reply r;
    UsbBytes h(48);
    if (read(line_.get(), h.data(), 48) != 48) return r;
    r.command = word(h, 0);
    r.sequence = word(h, 4);
    r.status = static_cast<std::int32_t>(word(h, 20));
    if (r.command == 3 && incoming_[r.sequence % 256]) r.data.resize(word(h, 24));
    const auto size = static_cast<ssize_t>(r.data.size());
    if (size > 0) {
      EXPECT_EQ(read(line_.get(), r.data.data(), r.data.size()), size);
    }
    return r;
  }
  Reply control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                std::uint16_t length, const UsbBytes& out = {}) {
    const auto low = [](std::uint16_t v) { return static_cast<std::uint8_t>(v & 255); };
    const auto high = [](std::uint16_t v) { return static_cast<std::uint8_t>(v >> 8); };
    submit(0, (type & 0x80) != 0, length,
           {type, request, low(value), high(value), low(index), high(index), low(length),
            high(length)},
           out);
    serve(0);
    return reply();
  }
  void ask_in(std::uint32_t length) { submit(1, true, length, UsbBytes(8), {}); }
  void send_out(const UsbBytes& data) {
    submit(2, false, static_cast<std::uint32_t>(data.size()), UsbBytes(8), data);
  }
  void take_back(std::uint32_t victim) {
    UsbBytes h;
    for (const std::uint32_t w : {2u, ++sequence_, 0u, 0u, 0u, victim}) put(h, w);
    h.resize(48);
    write_all(h);
  }
  std::uint32_t sequence() const { return sequence_; }
  bool plugged() const { return plug_.fd() >= 0; }

 private:
  static std::uint32_t word(const UsbBytes& b, std::size_t at) {
    return static_cast<std::uint32_t>(b[at] << 24 | b[at + 1] << 16 | b[at + 2] << 8 | b[at + 3]);
  }
  static void put(UsbBytes& out, std::uint32_t w) {
    for (int shift = 24; shift >= 0; shift -= 8)
      out.push_back(static_cast<std::uint8_t>(w >> shift));
  }
  void submit(std::uint32_t endpoint, bool in, std::uint32_t length, const UsbBytes& setup,
              const UsbBytes& data) {
    UsbBytes h;
    ++sequence_;
    incoming_[sequence_ % 256] = in;
    for (const std::uint32_t w :
         {1u, sequence_, 0u, in ? 1u : 0u, endpoint, 0u, length, 0u, 0u, 0u})
      put(h, w);
    h.insert(h.end(), setup.begin(), setup.end());
    h.insert(h.end(), data.begin(), data.end());
    write_all(h);
  }
  void write_all(const UsbBytes& bytes) {
    ASSERT_EQ(write(line_.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  UsbipPlug plug_;
  FileDescriptor line_;
  std::array<bool, 256> incoming_{};
  std::uint32_t sequence_ = 0;
};

TEST(UsbChip, TellsWhoItIs) {
  FtdiFunction chip;
  Kernel kernel(chip);
  const UsbBytes device = kernel.control(0x80, 6, 0x0100, 0, 18).data;
  ASSERT_EQ(device.size(), 18u);
  EXPECT_EQ(device[8] | device[9] << 8, 0x0403);
  EXPECT_EQ(device[10] | device[11] << 8, 0x6014);
  EXPECT_EQ(kernel.control(0x80, 6, 0x0100, 0, 8).data.size(), 8u) << "no more than was asked for";
  const UsbBytes configuration = kernel.control(0x80, 6, 0x0200, 0, 255).data;
  EXPECT_EQ(configuration.size(), static_cast<std::size_t>(configuration[2])) << "its own length";
  const UsbBytes serial = kernel.control(0x80, 6, 0x0303, 0x409, 255).data;
  EXPECT_EQ(serial[0], serial.size());
  EXPECT_EQ(serial[2], 'S');
  EXPECT_EQ(kernel.control(0x80, 6, 0x0700, 0, 255).status, -EPIPE) << "what it has not: a stall";
}

/// Divisors from FTDI's AN232B-05 and the data sheet, not from the controller's own function.
TEST(UsbChip, KnowsTheBitRateFromTheDivisor) {
  const struct {
    std::uint16_t value, index;
    int baud;
  } kRates[] = {{0x0006, 0x0200, 2'000'000},
                {0x0004, 0x0200, 3'000'000},
                {0x000C, 0x0200, 1'000'000},
                {0x0003, 0x0000, 1'000'000},
                {0x4138, 0x0000, 9600}};
  FtdiFunction chip;
  Kernel kernel(chip);
  for (const auto& rate : kRates) {
    EXPECT_EQ(kernel.control(0x40, 3, rate.value, rate.index, 0).status, 0);
    EXPECT_EQ(chip.baud(), rate.baud);
  }
}

TEST(UsbChip, HoldsShortPacketsBackUntilItsTimerEnds) {
  FtdiFunction chip;
  Kernel kernel(chip);
  EXPECT_EQ(kernel.control(0xC0, 10, 0, 0, 1).data, UsbBytes{16}) << "as it comes from the maker";
  kernel.control(0x40, 9, 1, 0, 0);
  EXPECT_EQ(kernel.control(0xC0, 10, 0, 0, 1).data, UsbBytes{1});
  kernel.ask_in(512);
  kernel.serve(kMillisecond);
  EXPECT_EQ(kernel.reply().data, (UsbBytes{1, 0x60})) << "nothing but its status";
  kernel.ask_in(512);
  chip.line_in(UsbBytes{7, 8, 9});
  kernel.serve(2 * kMillisecond - 1);
  EXPECT_EQ(kernel.reply().status, kPending);
  kernel.serve(2 * kMillisecond);
  EXPECT_EQ(kernel.reply().data, (UsbBytes{1, 0x60, 7, 8, 9}));
}

TEST(UsbChip, SendsFullPacketsAtOnceEachWithItsStatus) {
  FtdiFunction chip;
  Kernel kernel(chip);
  kernel.ask_in(4096);
  kernel.serve(0);
  (void)kernel.reply();
  UsbBytes all(1000);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
  kernel.ask_in(4096);
  chip.line_in(all);
  kernel.serve(1);
  const UsbBytes got = kernel.reply().data;
  ASSERT_EQ(got.size(), 1000u + 2 * 2);
  UsbBytes payload(got.begin() + 2, got.begin() + 512);
  payload.insert(payload.end(), got.begin() + 514, got.end());
  EXPECT_EQ(payload, all);
}

TEST(UsbChip, WhatTheHostSendsComesOutOnTheLine) {
  FtdiFunction chip;
  Kernel kernel(chip);
  kernel.send_out({1, 2, 3});
  kernel.send_out({4});
  kernel.serve(0);
  EXPECT_EQ(kernel.reply().status, 0);
  EXPECT_EQ(chip.line_out(), (UsbBytes{1, 2, 3, 4}));
  EXPECT_TRUE(chip.line_out().empty());
}

TEST(UsbPlug, ATransferThatIsTakenBackIsNeverAnswered) {
  FtdiFunction chip;
  Kernel kernel(chip);
  kernel.ask_in(512);
  kernel.serve(0);
  (void)kernel.reply();
  kernel.ask_in(512);
  const std::uint32_t victim = kernel.sequence();
  kernel.take_back(victim);
  kernel.serve(1);
  const Kernel::Reply reply = kernel.reply();
  EXPECT_EQ(reply.command, 4u);
  EXPECT_EQ(reply.status, -ECONNRESET);
  kernel.serve(kSecond);
  EXPECT_EQ(kernel.reply().status, kPending);
  kernel.take_back(victim);
  kernel.serve(kSecond);
  EXPECT_EQ(kernel.reply().status, 0) << "it had ended before";
}

TEST(UsbPlug, HangsUpOnWhatIsNotTheProtocol) {
  FtdiFunction chip;
  Kernel kernel(chip);
  kernel.send_out(UsbBytes(10));
  kernel.serve(0);
  EXPECT_TRUE(kernel.plugged());
  kernel.take_back(0);
  for (int i = 0; i < 3; ++i) kernel.send_out(UsbBytes(3));
  kernel.serve(0);
  EXPECT_TRUE(kernel.plugged());
  {
    FtdiFunction other;
    UsbipPlug plug(other);
    int pair[2] = {-1, -1};
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, pair), 0);
    plug.serve_on(FileDescriptor(pair[0]));
    const FileDescriptor far(pair[1]);
    const UsbBytes junk(200, 0xAB);
    ASSERT_EQ(write(far.get(), junk.data(), junk.size()), 200);
    plug.serve(0);
    EXPECT_LT(plug.fd(), 0);
  }
}

TEST(UsbSensor, ReportsOnceItsFeaturesAreSet) {
  EmulatedRobot robot(plant::load_world("hung"), 1);
  HidFunction sensor(robot);
  Kernel kernel(sensor);
  const std::span<const std::uint8_t> descriptor = EmulatedRobot::imu_descriptor();
  EXPECT_EQ(kernel.control(0x81, 6, 0x2200, 0, 4096).data,
            UsbBytes(descriptor.begin(), descriptor.end()));
  const UsbBytes hid = kernel.control(0x80, 6, 0x0200, 0, 255).data;
  EXPECT_EQ(static_cast<std::size_t>(hid[25] | hid[26] << 8), descriptor.size());
  kernel.ask_in(64);
  const std::uint32_t asked = kernel.sequence();
  robot.advance(50 * kMillisecond);
  kernel.serve(0);
  EXPECT_EQ(kernel.reply().status, kPending) << "silent until it is switched on";
  UsbBytes feature = kernel.control(0xA1, 1, 0x0301, 0, 64).data;
  ASSERT_GE(feature.size(), 3u);
  EXPECT_EQ(feature[0], 1) << "its number";
  feature[1] = 1;  // all events
  feature[2] = 1;  // full power
  EXPECT_EQ(kernel.control(0x21, 9, 0x0301, 0, static_cast<std::uint16_t>(feature.size()), feature)
                .status,
            0);
  robot.advance(100 * kMillisecond);
  kernel.serve(0);
  const Kernel::Reply report = kernel.reply();
  EXPECT_EQ(report.sequence, asked);
  ASSERT_FALSE(report.data.empty());
  EXPECT_EQ(report.data[0], 1);
}

}  // namespace
}  // namespace sanso::emulator
