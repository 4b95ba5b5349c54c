// The device list over a folder that looks like a machine, and the names that settings may hold.
#include "firmware/board/device_list.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "firmware/app/devices.h"
#include "firmware/board/hid_names.h"
#include "tests/support/temp_folder.h"

namespace sanso::board {
namespace {

namespace fs = std::filesystem;

class Machine {
 public:
  void file(const std::string& path, const std::string& text) {
    fs::create_directories((folder_.path() / path).parent_path());
    std::ofstream(folder_.path() / path) << text;
  }
  void link(const std::string& path, const std::string& to) {
    fs::create_directories((folder_.path() / path).parent_path());
    fs::create_symlink(to, folder_.path() / path);
  }
  std::string root() const { return folder_.path().string(); }

 private:
  test::TempFolder folder_;
};

TEST(DeviceList, ATtyHasItsStableNameDriverAndLatency) {
  Machine machine;
  machine.link("sys/class/tty/ttyUSB3/device/driver", "../../drivers/ftdi_sio");
  machine.file("sys/bus/usb-serial/devices/ttyUSB3/latency_timer", "16\n");
  machine.link("dev/serial/by-id/usb-FTDI_U2D2_FT1-if00-port0", "../../ttyUSB3");
  machine.file("dev/ttyUSB3", "");
  machine.file("sys/class/tty/tty0/uevent", "");  // a console is no adapter
  const auto list = list_ttys(machine.root());
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].setting, "bus = \"/dev/serial/by-id/usb-FTDI_U2D2_FT1-if00-port0\"");
  EXPECT_NE(list[0].what.find("driver ftdi_sio, latency 16 ms"), std::string::npos);
  EXPECT_EQ(list[0].obstacle, "");
}

TEST(DeviceList, AHidDeviceIsNamedByItsNumbersAndJudged) {
  Machine machine;
  machine.file("sys/class/hidraw/hidraw2/device/uevent",
               "DRIVER=hid-generic\nHID_ID=0003:00001209:00000001\nHID_NAME=Lab IMU\n"
               "HID_UNIQ=A7\n");
  machine.file("sys/class/hidraw/hidraw2/device/report_descriptor", "abc");
  const auto judge = [](std::span<const std::uint8_t> d, HidIdentity id) {
    return d.size() == 3 && id.vendor == 0x1209 ? std::string("is no IMU") : std::string();
  };
  const auto list = list_hidraw(machine.root(), judge);
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].setting, "imu = \"hidraw:1209:0001:A7\"");
  EXPECT_EQ(list[0].obstacle, "is no IMU");
  const std::string table = device_table("HID", list);
  EXPECT_NE(table.find("cannot be used: is no IMU"), std::string::npos);
}

TEST(DeviceList, AMachineWithoutDevicesSaysSo) {
  EXPECT_EQ(device_table("serial", list_ttys(Machine().root())), "serial\n  none\n");
}

TEST(DeviceNames, SelectorsAreReadAndWrongOnesRefused) {
  const auto s = parse_selector("0403:6014:FT1:2");
  ASSERT_TRUE(s.has_value());
  EXPECT_EQ(s->identity.vendor, 0x0403);
  EXPECT_EQ(s->identity.product, 0x6014);
  EXPECT_EQ(s->serial, "FT1:2");
  for (const char* bad : {"", "0403", "0403:", "0403:6014:", "0403:60147", "x403:6014"})
    EXPECT_FALSE(parse_selector(bad).has_value()) << bad;
}

TEST(DeviceNames, OneLineChoosesTheBackEnd) {
  firmware::DeviceConfig config;
  Devices devices;
  std::string error;
  for (const char* bus : {"/dev/ttyUSB0", "ftdi:0403:6014", "ftdi:0403:6014:FT1"}) {
    config.bus = bus;
    EXPECT_TRUE(make_devices(config, {}, devices, error)) << bus << ": " << error;
  }
  for (const char* imu : {"/dev/hidraw0", "unix:/tmp/x", "hidraw:1209:0001", "mip:/dev/ttyACM0",
                          "hidapi-libusb:1209:0001:A", "hidapi-hidraw:1209:0001"}) {
    config.imu = imu;
    EXPECT_TRUE(make_devices(config, {}, devices, error)) << imu << ": " << error;
  }
  config.imu = "hidapi-libusb:1209";
  EXPECT_FALSE(make_devices(config, {}, devices, error));
  EXPECT_NE(error.find("expected hidapi-libusb:VID:PID"), std::string::npos) << error;
}

}  // namespace
}  // namespace sanso::board
