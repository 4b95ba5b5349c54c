// The class's requests are handed to the robot, which knows its reports.
#include "tools/emulator/usb/hid_function.h"

namespace sanso::emulator {
namespace {

constexpr std::uint8_t kHidDescriptor = 0x21, kReportDescriptor = 0x22;
constexpr std::uint8_t kGetDescriptor = 6;
enum Request : std::uint8_t { kGetReport = 1, kSetReport = 9, kSetIdle = 10, kSetProtocol = 11 };
constexpr std::uint8_t kFeature = 3;
constexpr std::size_t kHidDescriptorAt = 18, kHidDescriptorBytes = 9;

UsbDescription description_of_sensor() {
  const std::size_t report = EmulatedRobot::imu_descriptor().size();
  UsbDescription d{0x1209, 0x5A50, 0x0100, "sanso", "emulated IMU", "SANSO002", {}};
  d.configuration = {9,
                     2,
                     34,
                     0,
                     1,
                     1,
                     0,
                     0x80,
                     50,  //
                     9,
                     4,
                     0,
                     0,
                     1,
                     3,
                     0,
                     0,
                     0,  //
                     9,
                     kHidDescriptor,
                     0x11,
                     0x01,
                     0,
                     1,
                     kReportDescriptor,
                     static_cast<std::uint8_t>(report & 0xFF),
                     static_cast<std::uint8_t>(report >> 8),  //
                     7,
                     5,
                     0x81,
                     3,
                     64,
                     0,
                     4};  // 2^(4-1) microframes: 1 ms
  return d;
}

}  // namespace

HidFunction::HidFunction(EmulatedRobot& robot)
    : UsbFunction(description_of_sensor()), robot_(robot) {}

std::optional<UsbBytes> HidFunction::own_request(const UsbSetup& setup,
                                                 std::span<const std::uint8_t> out) {
  const bool to_host = (setup.type & 0x80) != 0, of_class = (setup.type & 0x60) == 0x20;
  if (!of_class && setup.request == kGetDescriptor) {
    if (setup.value >> 8 == kReportDescriptor) {
      const std::span<const std::uint8_t> report = EmulatedRobot::imu_descriptor();
      return UsbBytes{report.begin(), report.end()};
    }
    if (setup.value >> 8 == kHidDescriptor) {
      const auto from = description().configuration.begin() + kHidDescriptorAt;
      return UsbBytes{from, from + kHidDescriptorBytes};
    }
    return std::nullopt;
  }
  if (setup.request == kGetReport && to_host && setup.value >> 8 == kFeature) {
    UsbBytes report(64);
    report.resize(robot_.imu_get_feature(static_cast<std::uint8_t>(setup.value & 0xFF), report));
    if (report.empty()) return std::nullopt;
    return report;
  }
  if (setup.request == kSetReport && setup.value >> 8 == kFeature)
    return robot_.imu_set_feature(out) ? std::optional<UsbBytes>(UsbBytes{}) : std::nullopt;
  if (setup.request == kSetIdle || setup.request == kSetProtocol) return UsbBytes{};
  return std::nullopt;
}

std::optional<UsbBytes> HidFunction::transfer(Nanoseconds, std::size_t capacity) {
  UsbBytes report(capacity);
  report.resize(robot_.imu_read(report));
  if (report.empty()) return std::nullopt;
  return report;
}

}  // namespace sanso::emulator
