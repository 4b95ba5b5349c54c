// A HID sensor through hidapi, found by vendor, product and serial number. hidapi allocates while
// it reads, which is why only the IMU thread does. One source at a time may use a back end: to
// search anew, it ends and begins it.
#pragma once

#include <array>
#include <functional>
#include <string>

#include "firmware/board/reconnect.h"
#include "firmware/board/usb/hid_api.h"
#include "firmware/board/usb/usb_line.h"

namespace sanso::board {

/// The report descriptor of the device at `path` (hidapi's), which hidapi 0.13 does not give: empty
/// and `message` when it cannot be had.
using DescriptorReader =
    std::function<std::vector<std::uint8_t>(const hid_device_info& device, std::string& message)>;

class HidapiSource final : public OpenableHid {
 public:
  HidapiSource(const HidApi* api, DescriptorReader descriptor, UsbIdentity wanted)
      : api_(api), read_descriptor_(std::move(descriptor)), wanted_(std::move(wanted)) {}
  ~HidapiSource() override { close(); }
  HidapiSource(const HidapiSource&) = delete;
  HidapiSource& operator=(const HidapiSource&) = delete;

  Status open(std::string& message) override;
  Bytes descriptor() override { return descriptor_; }
  HidIdentity identity() override { return {wanted_.vendor, wanted_.product}; }
  Status set_feature(Bytes report) override;
  Result<std::size_t> get_feature(Buffer report) override;
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;

 private:
  void close();

  const HidApi* api_;  // null: the back end is not there
  DescriptorReader read_descriptor_;
  UsbIdentity wanted_;
  hid_device* device_ = nullptr;
  std::vector<std::uint8_t> descriptor_;
};

/// From sysfs, for the hidraw back end: paths are /dev/hidrawN.
std::vector<std::uint8_t> descriptor_from_sysfs(const hid_device_info& device,
                                                std::string& message);
/// By a control transfer before hidapi opens the device, for the libusb back end.
std::vector<std::uint8_t> descriptor_from_usb(const hid_device_info& device, std::string& message);

}  // namespace sanso::board
