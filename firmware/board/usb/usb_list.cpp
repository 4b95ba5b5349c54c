// The part of the device list that asks libusb and hidapi (device_list.h).
#include <cstdio>
#include <cstring>
#include <cwchar>
#include <set>
#include <string>

#include "firmware/board/device_list.h"
#include "firmware/board/usb/hidapi_source.h"
#include "firmware/board/usb/libusb_line.h"

namespace sanso::board {
namespace {

constexpr std::uint16_t kFtdi = 0x0403;

std::string selector_of(std::uint16_t vendor, std::uint16_t product, const std::string& serial) {
  char numbers[16];
  std::snprintf(numbers, sizeof numbers, "%04x:%04x", vendor, product);
  return numbers + (serial.empty() ? std::string() : ":" + serial);
}

std::string narrow(const wchar_t* wide) {
  std::string text;
  for (; wide != nullptr && *wide != 0; ++wide)
    text += *wide < 128 ? static_cast<char>(*wide) : '?';
  return text;
}

void list_back_end(HidBackEnd which, const char* prefix, const DescriptorReader& reader,
                   const HidJudge& judge, std::vector<ListedDevice>& found) {
  ListedDevice device;
  const HidApi* api = hid_api(which, device.obstacle);
  if (api == nullptr) {
    device.setting = std::string("imu = \"") + prefix + ":...\"";
    found.push_back(device);
    return;
  }
  hid_device_info* list = api->enumerate(0, 0);
  std::set<std::string> seen;  // the library lists a device once for each usage
  for (const hid_device_info* d = list; d != nullptr; d = d->next) {
    if (!seen.insert(d->path).second) continue;
    device = {};
    device.setting = std::string("imu = \"") + prefix + ":" +
                     selector_of(d->vendor_id, d->product_id, narrow(d->serial_number)) + "\"";
    device.what = std::string(d->path) + ", " + narrow(d->product_string);
    const std::vector<std::uint8_t> descriptor = reader(*d, device.obstacle);
    if (!descriptor.empty()) device.obstacle = judge(descriptor, {d->vendor_id, d->product_id});
    found.push_back(device);
  }
  if (list != nullptr) api->free_enumeration(list);
}

}  // namespace

std::vector<ListedDevice> list_ftdi() {
  std::vector<ListedDevice> found;
  for (const LibusbLibrary::Listed& usb : LibusbLibrary().list(kFtdi)) {
    const UsbIdentity& id = usb.identity;
    found.push_back({"bus = \"ftdi:" + selector_of(id.vendor, id.product, id.serial) + "\"",
                     "through libusb, without the tty driver", usb.obstacle});
  }
  return found;
}

std::vector<ListedDevice> list_hidapi(const HidJudge& judge) {
  std::vector<ListedDevice> found;
  list_back_end(HidBackEnd::libusb, "hidapi-libusb", descriptor_from_usb, judge, found);
  list_back_end(HidBackEnd::hidraw, "hidapi-hidraw", descriptor_from_sysfs, judge, found);
  return found;
}

}  // namespace sanso::board
