// UsbLibrary on libusb-1.0.
#pragma once

#include "firmware/board/usb/usb_line.h"

struct libusb_context;

namespace sanso::board {

class LibusbLibrary final : public UsbLibrary {
 public:
  LibusbLibrary();
  ~LibusbLibrary() override;
  LibusbLibrary(const LibusbLibrary&) = delete;
  LibusbLibrary& operator=(const LibusbLibrary&) = delete;

  std::unique_ptr<UsbLine> open(const UsbIdentity& wanted, std::string& message) override;

  /// A device as the bus lists it, and why it cannot be opened (empty: it can).
  struct Listed {
    UsbIdentity identity;
    std::string obstacle;
  };
  /// All devices of this vendor, serial numbers read where permitted.
  std::vector<Listed> list(std::uint16_t vendor) const;

 private:
  libusb_context* context_ = nullptr;
};

}  // namespace sanso::board
