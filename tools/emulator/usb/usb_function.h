// A USB device as its host sees it, without the way there: descriptors, control requests, and one
// endpoint in each direction. Source: USB 2.0, chapter 9.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/base/time.h"

namespace sanso::emulator {

using UsbBytes = std::vector<std::uint8_t>;

struct UsbSetup {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

/// What every device has to say about itself.
struct UsbDescription {
  std::uint16_t vendor = 0, product = 0, release = 0;
  std::string maker, name, serial;
  UsbBytes configuration;  // with its interfaces and endpoints
};

class UsbFunction {
 public:
  explicit UsbFunction(UsbDescription description) : description_(std::move(description)) {}
  virtual ~UsbFunction() = default;

  /// Data of a control request to the host, empty for one that has none; nothing: stall. `out`:
  /// data of one from the host.
  std::optional<UsbBytes> control(const UsbSetup& setup, std::span<const std::uint8_t> out);
  /// The host sends on the endpoint that goes out.
  virtual void receive(std::span<const std::uint8_t> data) = 0;
  /// A transfer for the host, which has asked for at most `capacity` bytes; nothing: not yet.
  virtual std::optional<UsbBytes> transfer(Nanoseconds now, std::size_t capacity) = 0;
  /// When transfer() may have something.
  virtual Nanoseconds next_transfer() const = 0;

 protected:
  const UsbDescription& description() const { return description_; }
  /// Requests of the device's class or its maker.
  virtual std::optional<UsbBytes> own_request(const UsbSetup& setup,
                                              std::span<const std::uint8_t> out) = 0;

 private:
  std::optional<UsbBytes> descriptor(std::uint16_t value) const;
  UsbDescription description_;
};

}  // namespace sanso::emulator
