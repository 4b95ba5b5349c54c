// One suite for the ways to an IMU that need no kernel device: the packet socket and hidapi, whose
// functions are a table with a sensor below it. Plain hidraw needs the kernel's uhid.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "firmware/board/linux_clock.h"
#include "firmware/board/linux_socket.h"
#include "firmware/board/usb/hidapi_source.h"
#include "tests/support/temp_folder.h"

namespace sanso::board {
namespace {

using ByteList = std::vector<std::uint8_t>;
const ByteList kDescriptor{0x05, 0x20, 0x09, 0x01, 0xA1, 0x01, 0xC0};

/// The sensor below hidapi's functions, which know no context: one at a time.
struct FakeSensor {
  std::mutex mutex;
  std::condition_variable changed;
  bool plugged = true;
  bool listed = false;  // plugged when the back end began: it hears of nothing that happens later
  int open_handles = 0;
  std::deque<ByteList> reports;
  ByteList feature;
  wchar_t serial[4] = L"S1";
  char path[8] = "fake";
} sensor;

int fake_init() {
  sensor.listed = sensor.plugged;
  return 0;
}
int fake_exit() {
  EXPECT_EQ(sensor.open_handles, 0) << "an open device would lose its context";
  return 0;
}
hid_device_info* fake_enumerate(unsigned short vendor, unsigned short product) {
  if (!sensor.listed || vendor != 0x1209 || product != 1) return nullptr;
  auto* info = new hid_device_info{};
  info->path = sensor.path;
  info->vendor_id = vendor;
  info->product_id = product;
  info->serial_number = sensor.serial;
  return info;
}
void fake_free(hid_device_info* list) { delete list; }
hid_device* fake_open(const char*) {
  sensor.open_handles += sensor.plugged ? 1 : 0;
  return sensor.plugged ? reinterpret_cast<hid_device*>(&sensor) : nullptr;
}
void fake_close(hid_device*) { --sensor.open_handles; }
int fake_read(hid_device*, unsigned char* data, size_t size, int ms) {
  std::unique_lock lock(sensor.mutex);
  const auto something = [] { return !sensor.plugged || !sensor.reports.empty(); };
  sensor.changed.wait_for(lock, std::chrono::milliseconds(ms), something);
  if (!sensor.plugged) return -1;
  if (sensor.reports.empty()) return 0;
  const ByteList report = sensor.reports.front();
  sensor.reports.pop_front();
  const std::size_t n = std::min(size, report.size());
  std::copy_n(report.begin(), n, data);
  return static_cast<int>(n);
}
int fake_send_feature(hid_device*, const unsigned char* data, size_t size) {
  const std::lock_guard lock(sensor.mutex);
  if (!sensor.plugged) return -1;
  sensor.feature.assign(data, data + size);
  return static_cast<int>(size);
}
int fake_get_feature(hid_device*, unsigned char* data, size_t size) {
  std::fill(data + 1, data + size, std::uint8_t{0x33});
  return static_cast<int>(size);
}
constexpr HidApi kFakeApi{fake_init,  fake_exit, fake_enumerate,    fake_free,       fake_open,
                          fake_close, fake_read, fake_send_feature, fake_get_feature};

class HidapiRig {
 public:
  HidapiRig() {
    sensor.plugged = true;
    sensor.listed = false;
    sensor.reports.clear();
    sensor.open_handles = 0;
  }
  OpenableHid& hid() { return source_; }
  void plug() { sensor.plugged = true; }
  void unplug() {
    const std::lock_guard lock(sensor.mutex);
    sensor.plugged = false;
    sensor.reports.clear();
    sensor.changed.notify_all();
  }
  /// Waits until the host has connected, where there is such a thing.
  void meet() {}
  void device_sends(const ByteList& report) {
    const std::lock_guard lock(sensor.mutex);
    sensor.reports.push_back(report);
    sensor.changed.notify_all();
  }
  ByteList device_feature() { return sensor.feature; }

 private:
  HidapiSource source_{&kFakeApi,
                       [](const hid_device_info&, std::string&) { return kDescriptor; },
                       {0x1209, 1, "S1", 0}};
};

class SocketRig {
 public:
  SocketRig() { plug(); }
  ~SocketRig() { unplug(); }
  OpenableHid& hid() { return source_; }
  void plug() {
    unplug();
    listener_ = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy(path_.begin(), path_.end(), address.sun_path);
    ASSERT_EQ(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(listener_, 1), 0);
    greeter_ = std::thread([this] {
      client_ = ::accept(listener_, nullptr, nullptr);
      if (client_ >= 0) (void)!::send(client_, kDescriptor.data(), kDescriptor.size(), 0);
    });
  }
  void meet() { greeter_.join(); }
  void unplug() {
    if (listener_ >= 0) ::shutdown(listener_, SHUT_RDWR);
    if (greeter_.joinable()) greeter_.join();
    if (client_ >= 0) ::close(client_);
    if (listener_ >= 0) ::close(listener_);
    client_ = listener_ = -1;
    ::unlink(path_.c_str());
  }
  void device_sends(const ByteList& report) {
    ASSERT_EQ(::send(client_, report.data(), report.size(), 0),
              static_cast<ssize_t>(report.size()));
  }
  ByteList device_feature() {
    ByteList bytes(64);
    const ssize_t n = ::recv(client_, bytes.data(), bytes.size(), 0);
    bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return bytes;
  }

 private:
  test::TempFolder folder_;
  std::string path_ = (folder_.path() / "imu").string();
  int listener_ = -1, client_ = -1;
  std::thread greeter_;
  SocketHid source_{path_};
};

template <class Rig>
class EveryHid : public ::testing::Test {
 protected:
  Status open() {
    const Status status = rig.hid().open(message);
    if (status == Status::ok) rig.meet();
    return status;
  }
  Rig rig;
  LinuxClock clock;
  std::string message;
  std::array<std::uint8_t, 64> buffer{};
};

using BackEnds = ::testing::Types<SocketRig, HidapiRig>;
TYPED_TEST_SUITE(EveryHid, BackEnds);

TYPED_TEST(EveryHid, AnAbsentSensorIsRefusedWithAReason) {
  this->rig.unplug();
  EXPECT_EQ(this->open(), Status::io_error);
  EXPECT_FALSE(this->message.empty());
  EXPECT_TRUE(this->rig.hid().descriptor().empty());
  EXPECT_EQ(this->rig.hid().read(this->buffer, 0).status(), Status::io_error);
}

TYPED_TEST(EveryHid, DescriptorReportsAndFeaturesTravel) {
  ASSERT_EQ(this->open(), Status::ok) << this->message;
  const Bytes descriptor = this->rig.hid().descriptor();
  EXPECT_EQ(ByteList(descriptor.begin(), descriptor.end()), kDescriptor);
  const ByteList report{3, 1, 4, 1, 5}, feature{2, 7, 1};
  this->rig.device_sends(report);
  const Result<std::size_t> n =
      this->rig.hid().read(this->buffer, this->clock.now() + 60 * kSecond);
  ASSERT_TRUE(n.ok());
  EXPECT_EQ(ByteList(this->buffer.begin(), this->buffer.begin() + 5), report);
  EXPECT_EQ(*n, 5u);
  ASSERT_EQ(this->rig.hid().set_feature(feature), Status::ok);
  EXPECT_EQ(this->rig.device_feature(), feature);
}

TYPED_TEST(EveryHid, ASilentSensorGivesNothingAtTheDeadline) {
  ASSERT_EQ(this->open(), Status::ok);
  const Nanoseconds deadline = this->clock.now() + 20 * kMillisecond;
  const Result<std::size_t> n = this->rig.hid().read(this->buffer, deadline);
  ASSERT_TRUE(n.ok());
  EXPECT_EQ(*n, 0u);
  EXPECT_GE(this->clock.now(), deadline);
}

TYPED_TEST(EveryHid, UnpluggedAndBackAHundredTimes) {
  for (int i = 0; i < 100; ++i) {
    this->rig.plug();
    ASSERT_EQ(this->open(), Status::ok) << i << ": " << this->message;
    this->rig.device_sends({1, 2});
    ASSERT_TRUE(this->rig.hid().read(this->buffer, this->clock.now() + 60 * kSecond).ok()) << i;
    this->rig.unplug();
    ASSERT_EQ(this->rig.hid().read(this->buffer, this->clock.now() + 60 * kSecond).status(),
              Status::io_error)
        << i;
  }
}

TEST(Hidapi, AnotherSerialNumberIsAnotherSensorAndHandlesAreClosed) {
  HidapiRig rig;
  std::string message;
  const auto reader = [](const hid_device_info&, std::string&) { return kDescriptor; };
  HidapiSource other(&kFakeApi, reader, {0x1209, 1, "S2", 0});
  EXPECT_EQ(other.open(message), Status::io_error);
  EXPECT_NE(message.find("not plugged in"), std::string::npos);
  {
    HidapiSource any(&kFakeApi, reader, {0x1209, 1, "", 0});
    ASSERT_EQ(any.open(message), Status::ok);
    ASSERT_EQ(any.open(message), Status::ok);
    EXPECT_EQ(sensor.open_handles, 1);
  }
  EXPECT_EQ(sensor.open_handles, 0);
}

TEST(Hidapi, BothBackEndsAreThere) {
  for (const HidBackEnd which : {HidBackEnd::libusb, HidBackEnd::hidraw}) {
    std::string message;
    const HidApi* api = hid_api(which, message);
    ASSERT_NE(api, nullptr) << message;
    hid_device_info* list = api->enumerate(0x1209, 0xFFFF);  // nobody's
    EXPECT_EQ(list, nullptr);
  }
}

}  // namespace
}  // namespace sanso::board
