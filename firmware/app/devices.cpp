// The text before the first colon of a device setting chooses the back end; without one it is a
// path of the kernel's.
#include "firmware/app/devices.h"

#include "firmware/board/hid_names.h"
#include "firmware/board/linux_hidraw.h"
#include "firmware/board/linux_serial.h"
#include "firmware/board/linux_socket.h"
#ifdef SANSO_HAVE_USB
#include "firmware/board/usb/ftdi_serial.h"
#include "firmware/board/usb/hidapi_source.h"
#include "firmware/board/usb/libusb_line.h"
#endif

namespace sanso::board {
namespace {

constexpr int kMipBaud = 921'600;  // over USB any speed will do

/// What follows `prefix` in `name`; nothing when it begins with something else.
std::optional<std::string> after(const std::string& name, const std::string& prefix) {
  if (name.rfind(prefix, 0) != 0) return std::nullopt;
  return name.substr(prefix.size());
}

/// The selector behind `prefix`; `error` when what stands there is none.
std::optional<DeviceSelector> selected(const std::string& key, const std::string& name,
                                       const std::string& prefix, std::string& error) {
  const auto rest = after(name, prefix);
  if (!rest) return std::nullopt;
  auto selector = parse_selector(*rest);
  if (!selector)
    error = "device." + key + " = '" + name + "': expected " + prefix +
            "VID:PID or VID:PID:SERIAL, four hexadecimal digits each; sanso-firmware --devices "
            "lists what is plugged in";
  return selector;
}

#ifdef SANSO_HAVE_USB
UsbIdentity usb_identity(const DeviceSelector& s) {
  return {s.identity.vendor, s.identity.product, s.serial, 0};
}

std::unique_ptr<OpenableSerial> make_ftdi(const DeviceSelector& selector, int baud, int priority) {
  static LibusbLibrary library;
  return std::make_unique<FtdiSerial>(library, usb_identity(selector), baud, priority);
}

std::unique_ptr<OpenableHid> make_hidapi(HidBackEnd which, const DeviceSelector& selector,
                                         std::string& error) {
  const HidApi* api = hid_api(which, error);
  if (api == nullptr) return nullptr;
  return std::make_unique<HidapiSource>(
      api, which == HidBackEnd::libusb ? descriptor_from_usb : descriptor_from_sysfs,
      usb_identity(selector));
}
#endif

std::unique_ptr<OpenableHid> make_imu(const std::string& name, std::string& error) {
  if (const auto path = after(name, "unix:")) return std::make_unique<SocketHid>(*path);
  if (const auto s = selected("imu", name, "hidraw:", error))
    return std::make_unique<LinuxHidraw>(*s);
#ifdef SANSO_HAVE_USB
  if (const auto s = selected("imu", name, "hidapi-libusb:", error))
    return make_hidapi(HidBackEnd::libusb, *s, error);
  if (const auto s = selected("imu", name, "hidapi-hidraw:", error))
    return make_hidapi(HidBackEnd::hidraw, *s, error);
#else
  if (after(name, "hidapi-"))
    error = "device.imu = '" + name + "': this program was built without hidapi";
#endif
  if (!error.empty()) return nullptr;
  return std::make_unique<LinuxHidraw>(name);
}

}  // namespace

std::unique_ptr<OpenableSerial> make_bus(const firmware::DeviceConfig& config, int baud,
                                         std::string& error) {
  if (const auto s = selected("bus", config.bus, "ftdi:", error)) {
#ifdef SANSO_HAVE_USB
    // above the tick: it waits for these transfers
    return make_ftdi(*s, baud, std::min(config.tick_priority + 5, 99));
#else
    error = "device.bus = '" + config.bus + "': this program was built without libusb";
    return nullptr;
#endif
  }
  if (!error.empty()) return nullptr;
  return std::make_unique<LinuxSerial>(config.bus, baud);
}

bool SwitchedBus::set_baud(int baud) {
  if (port_ && baud == baud_) return true;
  port_.reset();  // the device is exclusive
  message_.clear();
  port_ = make_bus(config_, baud, message_);
  if (port_ && port_->open(message_) != Status::ok) port_.reset();
  baud_ = baud;
  return port_ != nullptr;
}

std::vector<Reconnecting*> Devices::all() const {
  std::vector<Reconnecting*> list;
  if (bus) list.push_back(bus.get());
  if (imu) list.push_back(imu.get());
  if (mip) list.push_back(mip.get());
  if (pose) list.push_back(pose.get());
  return list;
}

bool make_devices(const firmware::DeviceConfig& config, const firmware::BusSettings& bus,
                  Devices& devices, std::string& error) {
  auto port = make_bus(config, static_cast<int>(bus.byte_rate_baud), error);
  if (port == nullptr) return false;
  devices.bus = std::make_unique<ReconnectingSerial>("bus " + config.bus, std::move(port));
  const std::string imu_name = "imu " + config.imu;
  if (const auto path = after(config.imu, "mip:")) {
    devices.mip = std::make_unique<ReconnectingSerial>(
        imu_name, std::make_unique<LinuxSerial>(*path, kMipBaud));
  } else if (config.imu != firmware::kBoardImu) {  // that one is read by the tick
    auto imu = make_imu(config.imu, error);
    if (imu == nullptr) return false;
    devices.imu = std::make_unique<ReconnectingHid>(imu_name, std::move(imu));
  }
  if (config.pose.empty()) return true;
  const auto path = after(config.pose, "unix:");
  if (!path) {
    error = "device.pose = '" + config.pose + "': expected unix:PATH";
    return false;
  }
  devices.pose = std::make_unique<ReconnectingPose>("pose " + config.pose,
                                                    std::make_unique<SocketPose>(*path));
  return true;
}

}  // namespace sanso::board
