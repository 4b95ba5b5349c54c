// hidapi for finding, opening, reading; the report descriptor comes from sysfs or by a control
// transfer, because hidapi 0.13 cannot give it.
#include "firmware/board/usb/hidapi_source.h"

#include <libusb-1.0/libusb.h>

#include <algorithm>
#include <cstdio>
#include <cwchar>
#include <fstream>
#include <iterator>

#include "firmware/board/linux_clock.h"

namespace sanso::board {
namespace {

constexpr std::size_t kMaxDescriptor = 4096;

bool same_text(const wchar_t* wide, const std::string& text) {
  if (wide == nullptr) return text.empty();
  return std::equal(text.begin(), text.end(), wide, wide + std::wcslen(wide),
                    [](char a, wchar_t b) { return static_cast<wchar_t>(a) == b; });
}

}  // namespace

void HidapiSource::close() {
  if (device_ != nullptr) api_->close(device_);
  device_ = nullptr;
  descriptor_.clear();
}

Status HidapiSource::open(std::string& message) {
  if (api_ == nullptr) {
    message = "hidapi is not there";
    return Status::io_error;
  }
  close();
  // the libusb back end learns of new devices from its context alone where no udev runs: a new one
  api_->exit();
  if (api_->init() != 0) {
    message = "hidapi cannot be started";
    return Status::io_error;
  }
  char name[16];
  std::snprintf(name, sizeof name, "%04x:%04x", wanted_.vendor, wanted_.product);
  message = std::string("HID device ") + name + " " + wanted_.serial + ": not plugged in";
  hid_device_info* list = api_->enumerate(wanted_.vendor, wanted_.product);
  for (hid_device_info* d = list; d != nullptr && device_ == nullptr; d = d->next) {
    if (!wanted_.serial.empty() && !same_text(d->serial_number, wanted_.serial)) continue;
    descriptor_ = read_descriptor_(*d, message);
    if (descriptor_.empty()) continue;
    device_ = api_->open_path(d->path);
    if (device_ == nullptr)
      message = std::string(d->path) +
                ": cannot be opened; a udev rule has to give this user the "
                "device, and no other program may hold it";
  }
  if (list != nullptr) api_->free_enumeration(list);
  if (device_ == nullptr) {
    descriptor_.clear();
    return Status::io_error;
  }
  message.clear();
  return Status::ok;
}

Status HidapiSource::set_feature(Bytes report) {
  if (device_ == nullptr) return Status::io_error;
  return api_->send_feature(device_, report.data(), report.size()) >= 0 ? Status::ok
                                                                        : Status::io_error;
}

Result<std::size_t> HidapiSource::get_feature(Buffer report) {
  if (device_ == nullptr) return Status::io_error;
  const int n = api_->get_feature(device_, report.data(), report.size());
  if (n < 0) return Status::io_error;
  return static_cast<std::size_t>(n);
}

Result<std::size_t> HidapiSource::read(Buffer buffer, Nanoseconds deadline) {
  if (device_ == nullptr) return Status::io_error;
  const Nanoseconds left = deadline - LinuxClock().now();
  // whole milliseconds, upwards: a wait of nothing in a loop would be a spin
  const int ms = left <= 0 ? 0 : static_cast<int>((left + kMillisecond - 1) / kMillisecond);
  const int n = api_->read_timeout(device_, buffer.data(), buffer.size(), ms);
  if (n < 0) return Status::io_error;
  return static_cast<std::size_t>(n);
}

std::vector<std::uint8_t> descriptor_from_sysfs(const hid_device_info& device,
                                                std::string& message) {
  const std::string path = device.path;
  const std::string name = path.substr(path.rfind('/') + 1);
  const std::string file = "/sys/class/hidraw/" + name + "/device/report_descriptor";
  std::ifstream in(file, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.empty() || bytes.size() > kMaxDescriptor) {
    message = file + ": cannot be read";
    return {};
  }
  return bytes;
}

std::vector<std::uint8_t> descriptor_from_usb(const hid_device_info& device, std::string& message) {
  constexpr std::uint8_t kStandardInterfaceIn = 0x81, kGetDescriptor = 6;
  constexpr std::uint16_t kReportDescriptor = 0x2200;
  std::vector<std::uint8_t> bytes(kMaxDescriptor);
  libusb_context* context = nullptr;
  message = std::string(device.path) +
            ": the report descriptor cannot be read; a udev rule has to "
            "give this user the device";
  // hidapi's paths name bus, ports, configuration and interface: 1-4.2:1.0
  unsigned bus = 0;
  char ports[64] = {};
  if (std::sscanf(device.path, "%u-%63[0-9.]", &bus, ports) != 2) return {};
  if (libusb_init(&context) != 0) return {};
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context, &devices);
  int read = -1;
  for (ssize_t i = 0; i < count && read <= 0; ++i) {
    std::uint8_t numbers[8];
    const int depth = libusb_get_port_numbers(devices[i], numbers, sizeof numbers);
    std::string here;
    for (int p = 0; p < depth; ++p) here += (p > 0 ? "." : "") + std::to_string(numbers[p]);
    if (libusb_get_bus_number(devices[i]) != bus || here != ports) continue;
    libusb_device_handle* handle = nullptr;
    if (libusb_open(devices[i], &handle) != 0) continue;
    libusb_set_auto_detach_kernel_driver(handle, 1);
    const int interface = std::max(0, device.interface_number);
    if (libusb_claim_interface(handle, interface) == 0) {
      read = libusb_control_transfer(handle, kStandardInterfaceIn, kGetDescriptor,
                                     kReportDescriptor, static_cast<std::uint16_t>(interface),
                                     bytes.data(), static_cast<std::uint16_t>(bytes.size()), 500);
      libusb_release_interface(handle, interface);
    }
    libusb_close(handle);
  }
  libusb_free_device_list(devices, 1);
  libusb_exit(context);
  bytes.resize(read > 0 ? static_cast<std::size_t>(read) : 0);
  return bytes;
}

}  // namespace sanso::board
