// Bytes of the chip's serial side, in lots as the caller takes them.
#include "tools/emulator/usb/usb_bus.h"

#include <algorithm>

namespace sanso::emulator {

std::size_t UsbBus::read(std::span<std::uint8_t> out) {
  const UsbBytes fresh = chip_.line_out();
  unread_.insert(unread_.end(), fresh.begin(), fresh.end());
  const std::size_t n = std::min(out.size(), unread_.size());
  std::copy_n(unread_.begin(), n, out.begin());
  unread_.erase(unread_.begin(), unread_.begin() + static_cast<std::ptrdiff_t>(n));
  return n;
}

Nanoseconds UsbBus::serve(Nanoseconds now) {
  plug_.serve(now);
  return plug_.next();
}

}  // namespace sanso::emulator
