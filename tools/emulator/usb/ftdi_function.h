// An FT232H as a U2D2 or a USB adapter has it: bit rate by divisor, latency timer, two status bytes
// at the head of every packet. What it says on its serial side is taken by line_out() and given by
// line_in(). Source: FTDI AN232B-04 (latency) and AN232B-05 (divisors).
#pragma once

#include "tools/emulator/usb/usb_function.h"

namespace sanso::emulator {

class FtdiFunction final : public UsbFunction {
 public:
  FtdiFunction();

  void receive(std::span<const std::uint8_t> data) override;
  std::optional<UsbBytes> transfer(Nanoseconds now, std::size_t capacity) override;
  Nanoseconds next_transfer() const override;

  /// What the host has sent since the last call.
  UsbBytes line_out();
  /// The chip has received this on its serial side.
  void line_in(std::span<const std::uint8_t> data);
  /// Of the line, as the host has set it; 0 before.
  int baud() const { return baud_; }

 private:
  std::optional<UsbBytes> own_request(const UsbSetup& setup,
                                      std::span<const std::uint8_t> out) override;

  UsbBytes out_, in_;
  int baud_ = 0;
  int latency_ms_ = 16;
  Nanoseconds timer_ = 0;  // when the latency timer ends
};

}  // namespace sanso::emulator
