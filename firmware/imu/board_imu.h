// The IMU that every OP3 has: the OpenCR board's, read over the servo bus in the tick. Gyro and
// accelerometer only; the orientation is estimated, since the board's own comes from the
// accelerometer alone. Real-time safe.
#pragma once

#include "firmware/bus/bus_master.h"
#include "firmware/imu/imu_assembler.h"

namespace sanso::firmware {

class BoardImu {
 public:
  BoardImu(const ImuSettings& settings, Mailbox<ImuSample>& out) : assembler_(settings, out) {}

  /// Publishes a sample from what the board has answered.
  void take(Nanoseconds now, const BoardReading& reading);

 private:
  ImuAssembler assembler_;
};

}  // namespace sanso::firmware
