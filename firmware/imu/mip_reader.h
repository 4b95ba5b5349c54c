// The IMU thread's work with a 3DM-GX5 on a serial device: ask for acceleration, rate and
// orientation at 500 Hz at most, take the packets, turn the maker's frames (down is positive) into
// ours. Yields the same samples as a HID sensor.
#pragma once

#include "firmware/board/board.h"
#include "firmware/imu/imu_assembler.h"
#include "firmware/imu/mip_parser.h"

namespace sanso::firmware {

class MipReader {
 public:
  MipReader(const ImuSettings& settings, board::SerialPort& port, board::Clock& clock,
            Mailbox<ImuSample>& out)
      : settings_(settings), port_(port), clock_(clock), assembler_(settings, out) {}

  /// As ImuReader::poll.
  Status poll(Nanoseconds deadline);
  std::uint32_t bad_packets() const { return parser_.bad_packets(); }

 private:
  Status start();
  void take(const MipSample& sample);

  ImuSettings settings_;
  board::SerialPort& port_;
  board::Clock& clock_;
  ImuAssembler assembler_;
  MipParser parser_;
  bool started_ = false;
  Nanoseconds heard_ = 0;
};

}  // namespace sanso::firmware
