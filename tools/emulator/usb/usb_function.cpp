// The standard requests that a host makes of any device while it gets to know it.
#include "tools/emulator/usb/usb_function.h"

namespace sanso::emulator {
namespace {

constexpr std::uint8_t kToHost = 0x80;
constexpr std::uint8_t kKindMask = 0x60;  // standard, class or maker's
constexpr std::uint8_t kRecipientMask = 0x1F, kDevice = 0;
enum Request : std::uint8_t {
  kGetStatus = 0,
  kGetDescriptor = 6,
  kGetConfiguration = 8,
};
enum Descriptor : std::uint8_t { kOfDevice = 1, kOfConfiguration = 2, kString = 3, kQualifier = 6 };
constexpr std::uint8_t kMaxControl = 64;

std::uint8_t low(std::uint16_t v) { return static_cast<std::uint8_t>(v & 0xFF); }
std::uint8_t high(std::uint16_t v) { return static_cast<std::uint8_t>(v >> 8); }

UsbBytes string_descriptor(const std::string& text) {
  UsbBytes bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), kString};
  for (const char c : text) bytes.insert(bytes.end(), {static_cast<std::uint8_t>(c), 0});
  return bytes;
}

}  // namespace

std::optional<UsbBytes> UsbFunction::descriptor(std::uint16_t value) const {
  const UsbDescription& d = description_;
  switch (value >> 8) {
    case kOfDevice:
      return UsbBytes{18,
                      kOfDevice,
                      0,
                      2,
                      0,
                      0,
                      0,
                      kMaxControl,
                      low(d.vendor),
                      high(d.vendor),
                      low(d.product),
                      high(d.product),
                      low(d.release),
                      high(d.release),
                      1,
                      2,
                      3,
                      1};
    case kOfConfiguration:
      return d.configuration;
    case kQualifier:
      return UsbBytes{10, kQualifier, 0, 2, 0, 0, 0, kMaxControl, 1, 0};
    case kString:
      if ((value & 0xFF) == 0) return UsbBytes{4, kString, 0x09, 0x04};  // English
      if ((value & 0xFF) == 1) return string_descriptor(d.maker);
      if ((value & 0xFF) == 2) return string_descriptor(d.name);
      if ((value & 0xFF) == 3) return string_descriptor(d.serial);
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

std::optional<UsbBytes> UsbFunction::control(const UsbSetup& setup,
                                             std::span<const std::uint8_t> out) {
  std::optional<UsbBytes> answer;
  const bool to_host = (setup.type & kToHost) != 0;
  const bool of_device = (setup.type & kRecipientMask) == kDevice;
  const bool asks_descriptor = to_host && setup.request == kGetDescriptor;
  // of the interface, the class knows the descriptors
  if ((setup.type & kKindMask) != 0 || (asks_descriptor && !of_device))
    answer = own_request(setup, out);
  else if (!to_host)
    answer = UsbBytes{};  // configuration, interface, features: there is only one of each
  else if (asks_descriptor)
    answer = descriptor(setup.value);
  else if (setup.request == kGetStatus)
    answer = UsbBytes{0, 0};
  else if (setup.request == kGetConfiguration)
    answer = UsbBytes{1};
  if (answer && to_host && answer->size() > setup.length) answer->resize(setup.length);
  return answer;
}

}  // namespace sanso::emulator
