// A tick as ROS 2 messages: the topics of the black box and the one type that ROS does not have.
#pragma once

#include "firmware/exchange/record.h"
#include "shared/mcap/writer.h"

namespace sanso::firmware {

/// Declares its topics at construction; the writer must outlive it.
class TickMessages {
 public:
  explicit TickMessages(mcap::Writer& out);
  /// `lost`: ticks so far that no file holds.
  void write(const LogRecord& record, std::uint64_t lost);

 private:
  void write_joints(std::uint16_t channel, const wire::Observation& o, const double* position,
                    const double* velocity);
  mcap::Writer& out_;
  std::uint16_t states_, commands_, currents_, supply_, imu_, odometry_, tick_;
};

}  // namespace sanso::firmware
