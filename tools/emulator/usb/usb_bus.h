// The servo bus behind an FTDI chip that is plugged into the running kernel.
#pragma once

#include "tools/emulator/bus_end.h"
#include "tools/emulator/usb/ftdi_function.h"
#include "tools/emulator/usb/usbip_plug.h"

namespace sanso::emulator {

class UsbBus final : public BusEnd {
 public:
  void plug() override { plug_.plug(); }
  void unplug() override { plug_.unplug(); }
  int fd() const override { return plug_.fd(); }
  std::string device() const override { return "FTDI chip 0403:6014:SANSO001"; }
  std::size_t read(std::span<std::uint8_t> out) override;
  void write(std::span<const std::uint8_t> bytes) override { chip_.line_in(bytes); }
  int baud() const override { return chip_.baud(); }
  Nanoseconds serve(Nanoseconds now) override;

 private:
  FtdiFunction chip_;
  UsbipPlug plug_{chip_};
  UsbBytes unread_;
};

}  // namespace sanso::emulator
