// A full packet leaves at once, a partial one, or only the status, when the latency timer ends.
#include "tools/emulator/usb/ftdi_function.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sanso::emulator {
namespace {

constexpr std::size_t kPacket = 512, kPayload = kPacket - 2, kFifo = 4096;
constexpr std::uint8_t kModemStatus = 0x01, kTransmitterEmpty = 0x60;
enum Request : std::uint8_t {
  kReset = 0,
  kModem = 5,
  kSetBaud = 3,
  kSetLatency = 9,
  kGetLatency = 10,
  kReadEeprom = 0x90
};
constexpr std::uint16_t kPurgeInput = 1;

UsbDescription description_of_chip() {
  UsbDescription d{0x0403, 0x6014, 0x0900, "FTDI", "Single RS232-HS", "SANSO001", {}};
  d.configuration = {9, 2, 32,   0, 1, 1,    0,    0x80, 45,  //
                     9, 4, 0,    0, 2, 0xFF, 0xFF, 0xFF, 2,   //
                     7, 5, 0x81, 2, 0, 2,    0,               //
                     7, 5, 0x02, 2, 0, 2,    0};
  return d;
}

/// 14 bits of whole divisor, 3 of eighths in a code of their own, and one that chooses the clock.
int baud_of(std::uint16_t value, std::uint16_t index) {
  constexpr std::array<double, 8> kEighths{0, 0.5, 0.25, 0.125, 0.375, 0.625, 0.75, 0.875};
  const unsigned high = index >> 8;  // the low byte names the channel
  const unsigned code = value >> 14 | (high & 1) << 2;
  const double clock = (high & 2) != 0 ? 12e6 : 3e6;
  const unsigned whole = value & 0x3FFF;
  double divisor = whole + kEighths[code];
  if (whole == 0 && code == 0) divisor = 1;
  if (whole == 1 && code == 0) divisor = 1.5;
  return static_cast<int>(std::lround(clock / divisor));
}

}  // namespace

FtdiFunction::FtdiFunction() : UsbFunction(description_of_chip()) {}

std::optional<UsbBytes> FtdiFunction::own_request(const UsbSetup& setup,
                                                  std::span<const std::uint8_t>) {
  switch (setup.request) {
    case kReset:
      if (setup.value <= kPurgeInput) in_.clear();
      return UsbBytes{};
    case kSetBaud:
      baud_ = baud_of(setup.value, setup.index);
      return UsbBytes{};
    case kSetLatency:
      latency_ms_ = std::max(1, setup.value & 0xFF);
      return UsbBytes{};
    case kModem:
      return UsbBytes{kModemStatus, kTransmitterEmpty};
    case kGetLatency:
      return UsbBytes{static_cast<std::uint8_t>(latency_ms_)};
    case kReadEeprom:
      return UsbBytes{0xFF, 0xFF};  // blank
    default:
      return UsbBytes{};  // flow, data bits, modem lines: nothing here depends on them
  }
}

void FtdiFunction::receive(std::span<const std::uint8_t> data) {
  out_.insert(out_.end(), data.begin(), data.end());
}

UsbBytes FtdiFunction::line_out() { return std::exchange(out_, {}); }

void FtdiFunction::line_in(std::span<const std::uint8_t> data) {
  const std::size_t room = kFifo - std::min(kFifo, in_.size());
  in_.insert(in_.end(), data.begin(),
             data.begin() + static_cast<std::ptrdiff_t>(std::min(room, data.size())));
}

std::optional<UsbBytes> FtdiFunction::transfer(Nanoseconds now, std::size_t capacity) {
  if (in_.size() < kPayload && now < timer_) return std::nullopt;
  timer_ = now + latency_ms_ * kMillisecond;
  UsbBytes packets;
  std::size_t taken = 0;
  do {  // full packets go on within one transfer, a partial one ends it
    const std::size_t n = std::min(kPayload, in_.size() - taken);
    if (packets.size() + 2 + n > capacity) break;
    packets.insert(packets.end(), {kModemStatus, kTransmitterEmpty});
    const auto from = in_.begin() + static_cast<std::ptrdiff_t>(taken);
    packets.insert(packets.end(), from, from + static_cast<std::ptrdiff_t>(n));
    taken += n;
    if (n < kPayload) break;
  } while (true);
  in_.erase(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(taken));
  return packets;
}

Nanoseconds FtdiFunction::next_transfer() const { return in_.size() >= kPayload ? 0 : timer_; }

}  // namespace sanso::emulator
