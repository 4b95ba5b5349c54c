// What FTDI's serial chips want to hear over USB, as numbers: requests, bit rate divisors, and the
// two status bytes at the head of every packet. Source: FTDI AN232B-05 and Linux ftdi_sio.
#pragma once

#include <cstdint>

#include "firmware/board/board.h"

namespace sanso::board::ftdi {

enum class Request : std::uint8_t {
  reset = 0,
  set_flow = 2,
  set_baud = 3,
  set_data = 4,
  set_latency = 9,
  get_latency = 10,
};

inline constexpr std::uint16_t kResetAll = 0, kPurgeInput = 1, kPurgeOutput = 2;
inline constexpr std::uint16_t kData8N1 = 8;
inline constexpr std::size_t kStatusBytes = 2;     // modem and line status, in every packet
inline constexpr std::uint8_t kLineErrors = 0x8E;  // second byte: overrun, parity, framing, FIFO

/// Chips by bcdDevice. Those from the 2232H on (but not the FT-X) divide 120 MHz, the others 48.
bool fast_clock(std::uint16_t release);

struct Divisor {
  std::uint16_t value = 0, index = 0;  // of the set_baud request
  double baud = 0;                     // what the chip really does
};

/// Divisor nearest to `baud`; out_of_range when the chip misses it by more than 3 %.
Result<Divisor> divisor_for(int baud, std::uint16_t release);

/// Moves the payload of a finished transfer to its front: every packet of `packet_bytes` begins
/// with the status bytes. Returns its length; adds the packets that report line errors.
std::size_t strip_status(Buffer transfer, std::size_t packet_bytes, std::uint32_t& line_errors);

}  // namespace sanso::board::ftdi
