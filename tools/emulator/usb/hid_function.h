// The emulated robot's IMU as a USB device of the HID class: its report descriptor, its features,
// an interrupt endpoint with a report in each millisecond. Source: USB HID 1.11.
#pragma once

#include "tools/emulator/emulated_robot.h"
#include "tools/emulator/usb/usb_function.h"

namespace sanso::emulator {

class HidFunction final : public UsbFunction {
 public:
  explicit HidFunction(EmulatedRobot& robot);

  void receive(std::span<const std::uint8_t>) override {}
  std::optional<UsbBytes> transfer(Nanoseconds now, std::size_t capacity) override;
  /// Reports come with the robot's clock: whoever advances it asks again.
  Nanoseconds next_transfer() const override { return INT64_MAX; }

 private:
  std::optional<UsbBytes> own_request(const UsbSetup& setup,
                                      std::span<const std::uint8_t> out) override;
  EmulatedRobot& robot_;
};

}  // namespace sanso::emulator
