// Divisors in eighths of the chip's clock; the fraction has a code of its own in three high bits.
#include "firmware/board/usb/ftdi_chip.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sanso::board::ftdi {
namespace {

constexpr std::uint16_t kRelease2232H = 0x0700, kRelease232H = 0x0900, kReleaseX = 0x1000;
constexpr std::uint16_t kRelease2232C = 0x0500;
constexpr double kSlowBase = 24e6, kFastBase = 96e6;  // eighths of 3 MHz and of 12 MHz
constexpr std::uint32_t kFastClockBit = 0x20000;      // divide by 10 instead of by 16
/// Code of the eighths in bits 14..16.
constexpr std::array<std::uint32_t, 8> kFraction{0, 3, 2, 4, 1, 5, 6, 7};

}  // namespace

bool fast_clock(std::uint16_t release) {
  return release >= kRelease2232H && release <= kRelease232H;
}

Result<Divisor> divisor_for(int baud, std::uint16_t release) {
  if (baud <= 0) return Status::out_of_range;
  const bool fast = fast_clock(release) && baud >= 1200;
  const double base = fast ? kFastBase : kSlowBase;
  const auto eighths = static_cast<std::uint32_t>(std::lround(base / baud));
  if (eighths < 8 || eighths >= 8u * 16384u) return Status::out_of_range;
  std::uint32_t code = (eighths >> 3) | (kFraction[eighths & 7] << 14);
  double real = base / eighths;
  // the two codes below 2 stand for 1 and for 1.5; nothing lies between
  if (eighths >= 8 && eighths < 16) {
    const bool one = eighths < 10;
    code = one ? 0 : 1;
    real = base / (one ? 8 : 12);
  }
  if (std::abs(real / baud - 1.0) > 0.03) return Status::out_of_range;
  if (fast) code |= kFastClockBit;
  Divisor divisor;
  divisor.value = static_cast<std::uint16_t>(code & 0xFFFF);
  divisor.index = static_cast<std::uint16_t>(code >> 16);
  // chips whose index carries the channel in its low byte
  if (fast_clock(release) || release == kRelease2232C || release >= kReleaseX)
    divisor.index = static_cast<std::uint16_t>(divisor.index << 8);
  divisor.baud = real;
  return divisor;
}

std::size_t strip_status(Buffer transfer, std::size_t packet_bytes, std::uint32_t& line_errors) {
  std::size_t out = 0;
  for (std::size_t at = 0; at < transfer.size(); at += packet_bytes) {
    const std::size_t size = std::min(packet_bytes, transfer.size() - at);
    if (size < kStatusBytes) break;
    if ((transfer[at + 1] & kLineErrors) != 0) ++line_errors;
    std::copy(transfer.begin() + static_cast<std::ptrdiff_t>(at + kStatusBytes),
              transfer.begin() + static_cast<std::ptrdiff_t>(at + size),
              transfer.begin() + static_cast<std::ptrdiff_t>(out));
    out += size - kStatusBytes;
  }
  return out;
}

}  // namespace sanso::board::ftdi
