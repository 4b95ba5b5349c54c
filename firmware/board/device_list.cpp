// Reads links and small files below /sys and tries to open each device; sends nothing to any.
#include "firmware/board/device_list.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "firmware/board/hid_names.h"

namespace sanso::board {
namespace {

namespace fs = std::filesystem;

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

std::vector<fs::path> entries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder, error)) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

/// Why this user cannot open the file; empty: he can.
std::string open_obstacle(const fs::path& file, const char* group) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor >= 0) {
    ::close(descriptor);
    return {};
  }
  std::string why = std::strerror(errno);
  if (errno == EACCES) why += std::string("; ") + group;
  if (errno == EBUSY) why += "; another program holds it exclusively";
  return why;
}

/// The link under /dev/serial/by-id that leads to `tty`, or the plain name.
std::string stable_name(const fs::path& root, const std::string& tty) {
  for (const fs::path& link : entries(root / "dev/serial/by-id")) {
    std::error_code error;
    if (fs::read_symlink(link, error).filename() == tty)
      return "/dev/serial/by-id/" + link.filename().string();
  }
  return "/dev/" + tty;
}

}  // namespace

std::vector<ListedDevice> list_ttys(const std::string& root) {
  const fs::path top = root.empty() ? "/" : root;
  std::vector<ListedDevice> found;
  for (const fs::path& tty : entries(top / "sys/class/tty")) {
    const std::string name = tty.filename().string();
    if (name.rfind("ttyUSB", 0) != 0 && name.rfind("ttyACM", 0) != 0) continue;
    std::error_code error;
    const std::string driver = fs::read_symlink(tty / "device/driver", error).filename().string();
    const std::string latency =
        first_line(top / "sys/bus/usb-serial/devices" / name / "latency_timer");
    ListedDevice device;
    device.setting = "bus = \"" + stable_name(top, name) + "\"";
    device.what = name + ", driver " + (driver.empty() ? "unknown" : driver);
    if (!latency.empty())
      device.what += ", latency " + latency + " ms" +
                     (latency == "1" ? "" : " (the controller sets 1 when it opens the port)");
    device.obstacle = open_obstacle(top / "dev" / name, "add the user to the group dialout");
    found.push_back(device);
  }
  return found;
}

std::vector<ListedDevice> list_hidraw(const std::string& root, const HidJudge& judge) {
  const fs::path top = root.empty() ? "/" : root;
  std::vector<ListedDevice> found;
  for (const HidName& hid : hid_names(root)) {
    std::ifstream in(top / "sys/class/hidraw" / hid.node / "device/report_descriptor",
                     std::ios::binary);
    const std::vector<std::uint8_t> descriptor{std::istreambuf_iterator<char>(in), {}};
    ListedDevice device;
    device.setting = "imu = \"hidraw:" + hid.selector() + "\"";
    device.what = "/dev/" + hid.node + ", " + hid.product_name;
    device.obstacle = judge(descriptor, hid.identity);
    if (device.obstacle.empty())
      device.obstacle =
          open_obstacle(top / "dev" / hid.node, "a udev rule has to give this user the device");
    found.push_back(device);
  }
  return found;
}

std::string device_table(const std::string& heading, const std::vector<ListedDevice>& devices) {
  std::string text = heading + "\n";
  if (devices.empty()) text += "  none\n";
  for (const ListedDevice& d : devices) {
    text += "  " + d.setting + "   # " + d.what + "\n";
    text += d.obstacle.empty() ? "    can be used\n" : "    cannot be used: " + d.obstacle + "\n";
  }
  return text;
}

}  // namespace sanso::board
