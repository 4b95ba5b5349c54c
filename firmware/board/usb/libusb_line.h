// UsbLibrary on libusb-1.0. Every search begins with a context of its own: an old one learns of new
// devices only from udev, which a container or a first boot stage has not.
#pragma once

#include "firmware/board/usb/usb_line.h"

namespace sanso::board {

class LibusbLibrary final : public UsbLibrary {
 public:
  std::unique_ptr<UsbLine> open(const UsbIdentity& wanted, std::string& message) override;

  /// A device as the bus lists it, and why it cannot be opened (empty: it can).
  struct Listed {
    UsbIdentity identity;
    std::string obstacle;
  };
  /// All devices of this vendor, serial numbers read where permitted.
  std::vector<Listed> list(std::uint16_t vendor) const;
};

}  // namespace sanso::board
