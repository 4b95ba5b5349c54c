// One line of the flight recorder: what a tick read, decided and sent.
#pragma once

#include <array>
#include <cstdint>

#include "shared/base/time.h"
#include "shared/wire/messages.h"

namespace sanso::firmware {

struct LogRecord {
  wire::Observation observation;
  std::array<std::int32_t, model::kNumJoints> position_raw{};  // counts, as read
  std::uint16_t fault_detail = 0;                              // servo id or count behind a fault
  std::uint32_t dropped = 0;  // records before this one for which the log's queue had no room
};

}  // namespace sanso::firmware
