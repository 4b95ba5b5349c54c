// One suite for every way to the servo bus: the tty driver (a pty) and libusb (an FTDI chip below
// it). What a back end promises is in board.h; how long something takes is not tested.
#include <gtest/gtest.h>
#include <unistd.h>

#include <thread>

#include "firmware/board/linux_clock.h"
#include "firmware/board/linux_serial.h"
#include "firmware/board/usb/ftdi_serial.h"
#include "tests/firmware/board/fake_chip.h"
#include "tests/firmware/board/pty.h"
#include "tests/support/temp_folder.h"

namespace sanso::board {
namespace {

using testing::FakeChip;
using ByteList = std::vector<std::uint8_t>;
constexpr int kBaud = 2'000'000;

class TtyRig {
 public:
  TtyRig() { pty_.plug(); }
  OpenableSerial& port() { return serial_; }
  void plug() { pty_.plug(); }
  void unplug() { pty_.pull(); }
  void device_sends(const ByteList& bytes) {
    ASSERT_EQ(::write(pty_.master(), bytes.data(), bytes.size()),
              static_cast<ssize_t>(bytes.size()));
  }
  ByteList device_gets(std::size_t count) {
    ByteList got(count);
    std::size_t have = 0;
    while (have < count) {
      const ssize_t n = ::read(pty_.master(), got.data() + have, count - have);
      if (n > 0) have += static_cast<std::size_t>(n);
    }
    return got;
  }

 private:
  test::TempFolder folder_;
  std::string link_ = (folder_.path() / "bus").string();
  testing::Pty pty_{link_};
  LinuxSerial serial_{link_, kBaud};
};

class FtdiRig {
 public:
  OpenableSerial& port() { return serial_; }
  void plug() { chip_.plug(); }
  void unplug() { chip_.unplug(); }
  void device_sends(const ByteList& bytes) { chip_.receive_serial(bytes); }
  ByteList device_gets(std::size_t count) {
    chip_.wait_for([&] { return chip_.sent.size() >= count; });
    return chip_.sent_serial();
  }

 private:
  FakeChip chip_;
  FtdiSerial serial_{chip_, {0x0403, 0x6014, "", 0}, kBaud, 0};
};

template <class Rig>
class SerialBackEnd : public ::testing::Test {
 protected:
  Status open() {
    message.clear();
    return rig.port().open(message);
  }
  /// Bytes until `count` are there; fewer when the port gives up.
  ByteList read(std::size_t count) {
    ByteList got;
    std::array<std::uint8_t, 64> buffer;
    while (got.size() < count) {
      const Result<std::size_t> n = rig.port().read(buffer, clock.now() + 60 * kSecond);
      if (!n.ok() || *n == 0) break;
      got.insert(got.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*n));
    }
    return got;
  }
  Rig rig;
  LinuxClock clock;
  std::string message;
};

using BackEnds = ::testing::Types<TtyRig, FtdiRig>;
TYPED_TEST_SUITE(SerialBackEnd, BackEnds);

TYPED_TEST(SerialBackEnd, AnAbsentDeviceIsRefusedWithAReason) {
  this->rig.unplug();
  EXPECT_EQ(this->open(), Status::io_error);
  EXPECT_FALSE(this->message.empty());
  const ByteList bytes{1, 2};
  EXPECT_EQ(this->rig.port().write(bytes), Status::io_error);
}

TYPED_TEST(SerialBackEnd, EveryByteValueTravelsBothWays) {
  ASSERT_EQ(this->open(), Status::ok) << this->message;
  ByteList all(256);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint8_t>(i);
  ASSERT_EQ(this->rig.port().write(all), Status::ok);
  EXPECT_EQ(this->rig.device_gets(256), all);
  this->rig.device_sends(all);
  EXPECT_EQ(this->read(256), all);
}

TYPED_TEST(SerialBackEnd, ASilentLineGivesNothingAtTheDeadline) {
  ASSERT_EQ(this->open(), Status::ok);
  std::array<std::uint8_t, 8> buffer;
  const Result<std::size_t> now = this->rig.port().read(buffer, 0);
  ASSERT_TRUE(now.ok());
  EXPECT_EQ(*now, 0u);
  const Nanoseconds deadline = this->clock.now() + 20 * kMillisecond;
  const Result<std::size_t> later = this->rig.port().read(buffer, deadline);
  ASSERT_TRUE(later.ok());
  EXPECT_EQ(*later, 0u);
  EXPECT_GE(this->clock.now(), deadline) << "it waits for the whole time";
}

TYPED_TEST(SerialBackEnd, AnUnplugEndsAWaitingReadAndStays) {
  ASSERT_EQ(this->open(), Status::ok);
  std::thread hand([&] {
    LinuxClock::sleep_until(this->clock.now() + 30 * kMillisecond);
    this->rig.unplug();
  });
  std::array<std::uint8_t, 8> buffer;
  EXPECT_EQ(this->rig.port().read(buffer, this->clock.now() + 60 * kSecond).status(),
            Status::io_error);
  hand.join();
  const ByteList bytes{1};
  EXPECT_EQ(this->rig.port().write(bytes), Status::io_error);
  EXPECT_EQ(this->rig.port().read(buffer, 0).status(), Status::io_error);
}

TYPED_TEST(SerialBackEnd, ComesBackAHundredTimes) {
  const ByteList word{0xFF, 0xFF, 0xFD, 0x00};
  for (int i = 0; i < 100; ++i) {
    this->rig.plug();
    ASSERT_EQ(this->open(), Status::ok) << i << ": " << this->message;
    this->rig.device_sends(word);
    ASSERT_EQ(this->read(word.size()), word) << i;
    this->rig.unplug();
    std::array<std::uint8_t, 8> buffer;
    ASSERT_EQ(this->rig.port().read(buffer, this->clock.now() + 60 * kSecond).status(),
              Status::io_error)
        << i;
  }
}

}  // namespace
}  // namespace sanso::board
