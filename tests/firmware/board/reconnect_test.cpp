// Devices that go and come back: absent, foreign, unplugged, replugged under another number, over
// interface fakes, real ptys and packet sockets.
#include "firmware/board/reconnect.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>

#include "firmware/board/linux_clock.h"
#include "firmware/board/linux_serial.h"
#include "firmware/board/linux_socket.h"
#include "tests/firmware/board/pty.h"
#include "tests/support/temp_folder.h"

namespace sanso::board {
namespace {

/// A port that is there or not, works or not.
class FakePort : public OpenableSerial {
 public:
  Status open(std::string& message) override {
    ++opens;
    if (!present) message = "absent";
    return present ? Status::ok : Status::io_error;
  }
  Status write(Bytes) override { return works() ? Status::ok : Status::io_error; }
  Result<std::size_t> read(Buffer out, Nanoseconds) override {
    ++touched;
    if (!works()) return Status::io_error;
    if (silent) return std::size_t{0};
    out[0] = 1;
    return std::size_t{1};
  }
  Status ready() override { return Status::ok; }
  bool works() const { return present && !broken; }
  bool present = true, broken = false, silent = false;
  int opens = 0, touched = 0;
};

struct Kept {
  std::unique_ptr<FakePort> made = std::make_unique<FakePort>();
  FakePort& port = *made;
  ReconnectingSerial bus{"bus", std::move(made)};
  std::array<std::uint8_t, 4> buffer{};
  Result<std::size_t> read() { return bus.read(buffer, 0); }
};

TEST(Reconnect, AnAbsentDeviceIsTriedWithGrowingPausesUpToASecond) {
  Kept k;
  k.port.present = false;
  std::vector<Nanoseconds> pauses;
  Nanoseconds now = 0;
  for (int i = 0; i < 10; ++i) {
    const Nanoseconds next = k.bus.mend(now);
    pauses.push_back(next - now);
    now = next;
  }
  EXPECT_EQ(pauses.front(), 10 * kMillisecond);
  EXPECT_TRUE(std::is_sorted(pauses.begin(), pauses.end()));
  EXPECT_EQ(pauses.back(), kSecond);
  EXPECT_EQ(k.port.opens, 10);
  EXPECT_EQ(k.bus.news(), "absent");
  EXPECT_EQ(k.bus.news(), "") << "said once";
}

TEST(Reconnect, NobodyTouchesADeviceThatIsDown) {
  Kept k;
  EXPECT_EQ(k.read().status(), Status::io_error);
  EXPECT_EQ(k.port.touched, 0);
  k.bus.mend(0);
  EXPECT_TRUE(k.read().ok());
  k.port.broken = true;
  EXPECT_EQ(k.read().status(), Status::io_error);
  EXPECT_EQ(k.bus.ready(), Status::not_ready);
  const int touched = k.port.touched;
  EXPECT_EQ(k.read().status(), Status::io_error);
  EXPECT_EQ(k.port.touched, touched);
}

TEST(Reconnect, AHundredUnplugsAreAHundredReturnsWithinOnePause) {
  Kept k;
  Nanoseconds now = 0;
  k.bus.mend(now);
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(k.read().ok()) << i;
    k.port.broken = true;
    ASSERT_FALSE(k.read().ok()) << i;
    k.port.broken = false;
    now = k.bus.mend(now);
    k.bus.mend(now);
    ASSERT_TRUE(k.bus.up()) << i;
  }
  EXPECT_EQ(k.bus.openings(), 101u);
  EXPECT_EQ(now, 100 * 10 * kMillisecond);
}

TEST(Reconnect, ADeviceThatOpensAndNeverWorksIsTriedLessAndLessOften) {
  Kept k;
  k.port.broken = true;
  Nanoseconds now = 0;
  k.bus.mend(now);
  for (int i = 0; i < 10; ++i) {
    (void)k.read();
    now = k.bus.mend(now);
    k.bus.mend(now);
  }
  EXPECT_GT(now, 3 * kSecond);
}

using testing::Pty;

/// Mends until the device is up, as the helper thread does.
bool mend_until_up(Reconnecting& device) {
  LinuxClock clock;
  for (int i = 0; i < 1000 && !device.up(); ++i)
    LinuxClock::sleep_until(std::min(device.mend(clock.now()), clock.now() + kSecond));
  return device.up();
}

TEST(Reconnect, APtyPulledAndReplacedAHundredTimes) {
  test::TempFolder folder;
  const std::string link = (folder.path() / "bus").string();
  Pty first(link), second(link);
  ReconnectingSerial bus(link, std::make_unique<LinuxSerial>(link, 2'000'000));
  LinuxClock clock;
  std::array<std::uint8_t, 8> buffer{};
  bus.mend(clock.now());
  EXPECT_FALSE(bus.up());  // absent at first
  for (int i = 0; i < 100; ++i) {
    Pty& pty = i % 2 == 0 ? first : second;
    pty.plug();
    ASSERT_TRUE(mend_until_up(bus)) << i;
    ASSERT_EQ(::write(pty.master(), "x", 1), 1) << i;
    const Result<std::size_t> n = bus.read(buffer, clock.now() + 10 * kSecond);
    ASSERT_TRUE(n.ok()) << i;
    ASSERT_EQ(*n, 1u) << i;
    if (i + 1 < 100) {  // the other one takes its number's place before this one goes
      Pty& other = i % 2 == 0 ? second : first;
      pty.pull();
      other.plug();
      other.pull();
    } else {
      pty.pull();
    }
    ASSERT_EQ(bus.read(buffer, clock.now() + 10 * kSecond).status(), Status::io_error) << i;
    ASSERT_FALSE(bus.up()) << i;
  }
}

/// A socket that takes connections and says nothing.
class SilentSocket {
 public:
  explicit SilentSocket(const std::string& path) : path_(path) {
    listener_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path.begin(), path.end(), address.sun_path);
    ::unlink(path.c_str());
    EXPECT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener_, 1), 0);
  }
  ~SilentSocket() {
    ::close(listener_);
    ::unlink(path_.c_str());
  }
  SilentSocket(const SilentSocket&) = delete;
  SilentSocket& operator=(const SilentSocket&) = delete;

 private:
  std::string path_;
  int listener_ = -1;
};

TEST(Reconnect, ASensorSocketThatGoesIsSeenAndASilentOneIsNoSensor) {
  test::TempFolder folder;
  const std::string path = (folder.path() / "imu").string();
  ReconnectingHid imu("imu", std::make_unique<SocketHid>(path));
  LinuxClock clock;
  imu.mend(clock.now());
  EXPECT_FALSE(imu.up());
  EXPECT_TRUE(imu.descriptor().empty());
  EXPECT_NE(imu.news().find("is the emulator running?"), std::string::npos);
  {
    SilentSocket silent(path);
    LinuxClock::sleep_until(clock.now() + 20 * kMillisecond);
    imu.mend(clock.now());
    EXPECT_FALSE(imu.up());
    EXPECT_NE(imu.news().find("no report descriptor within a second"), std::string::npos);
  }
}

}  // namespace
}  // namespace sanso::board
