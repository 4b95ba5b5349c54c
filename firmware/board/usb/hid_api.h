// hidapi as a table of its functions, so that one program can use both of its back ends and tests
// can put a sensor below it. The libusb back end is linked; the hidraw one has the same names and
// is therefore loaded beside it.
#pragma once

#include <hidapi/hidapi.h>

#include <string>

namespace sanso::board {

struct HidApi {
  int (*init)() = nullptr;
  int (*exit)() = nullptr;
  hid_device_info* (*enumerate)(unsigned short vendor, unsigned short product) = nullptr;
  void (*free_enumeration)(hid_device_info* list) = nullptr;
  hid_device* (*open_path)(const char* path) = nullptr;
  void (*close)(hid_device* device) = nullptr;
  int (*read_timeout)(hid_device* device, unsigned char* data, size_t size, int ms) = nullptr;
  int (*send_feature)(hid_device* device, const unsigned char* data, size_t size) = nullptr;
  int (*get_feature)(hid_device* device, unsigned char* data, size_t size) = nullptr;
};

enum class HidBackEnd { libusb, hidraw };

/// The functions of a back end, initialised once; null and `message` when it is not there.
const HidApi* hid_api(HidBackEnd which, std::string& message);

}  // namespace sanso::board
