// Two libraries with the same names in one program: one linked, the other loaded with names of its
// own and reached through pointers alone.
#include "firmware/board/usb/hid_api.h"

#include <dlfcn.h>

namespace sanso::board {
namespace {

constexpr char kHidrawLibrary[] = "libhidapi-hidraw.so.0";

template <class Function>
bool find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  return function != nullptr;
}

/// Local, so that its names stay behind those of the linked back end.
HidApi load_hidraw() {
  HidApi api;
  void* library = dlopen(kHidrawLibrary, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return {};
  const bool all = find(library, "hid_init", api.init) && find(library, "hid_exit", api.exit) &&
                   find(library, "hid_enumerate", api.enumerate) &&
                   find(library, "hid_free_enumeration", api.free_enumeration) &&
                   find(library, "hid_open_path", api.open_path) &&
                   find(library, "hid_close", api.close) &&
                   find(library, "hid_read_timeout", api.read_timeout) &&
                   find(library, "hid_send_feature_report", api.send_feature) &&
                   find(library, "hid_get_feature_report", api.get_feature);
  return all ? api : HidApi{};
}

HidApi linked_libusb() {
  return {
      hid_init,  hid_exit,         hid_enumerate,           hid_free_enumeration,  hid_open_path,
      hid_close, hid_read_timeout, hid_send_feature_report, hid_get_feature_report};
}

}  // namespace

const HidApi* hid_api(HidBackEnd which, std::string& message) {
  static const HidApi libusb = linked_libusb();
  static const HidApi hidraw = load_hidraw();
  const HidApi& api = which == HidBackEnd::libusb ? libusb : hidraw;
  if (api.init != nullptr && api.init() == 0) return &api;
  message = which == HidBackEnd::libusb
                ? "hidapi's libusb back end cannot be started"
                : std::string(kHidrawLibrary) + " is not installed (package libhidapi-hidraw0)";
  return nullptr;
}

}  // namespace sanso::board
