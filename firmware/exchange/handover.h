// Everything that the tick shares with the other threads: fixed size, lock-free, each queue with
// one producer and one consumer. The tick never waits for any of them.
#pragma once

#include <atomic>

#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/record.h"
#include "firmware/exchange/samples.h"
#include "firmware/exchange/spsc_ring.h"
#include "firmware/exchange/tick_times.h"
#include "shared/policy/policy_types.h"
#include "shared/policy/primitives.h"
#include "shared/wire/messages.h"

namespace sanso::firmware {

struct Handover {
  // link -> tick
  SpscRing<wire::Command, 16> commands;
  Mailbox<policy::PrimitiveSet> primitives;
  Mailbox<policy::MiddleTable> middle;
  Mailbox<policy::UpperPolicy> upper;
  std::atomic<Nanoseconds> host_heard{0};  // time of the last good datagram; 0: never
  std::atomic<std::uint32_t> datagrams_dropped{0};

  // anyone -> tick
  std::atomic<bool> emergency_stop{false};  // torque off, latched; the tick takes it back to false
  std::atomic<bool> end_requested{false};   // lower the robot and switch its torque off, then end

  // main -> tick, before the first one
  std::atomic<bool> arming_allowed{true};  // false: no real-time rights, and no setting allows that

  // tick -> main: after end_requested, the program may end
  std::atomic<bool> may_end{false};
  std::atomic<std::uint64_t> ticks{0};  // so many are done
  TickTimes times;                      // and took so long

  // IMU and pose threads -> tick
  Mailbox<ImuSample> imu;
  Mailbox<PoseSample> pose;

  // tick -> link
  SpscRing<wire::Observation, 16> observations;
  SpscRing<wire::CommandAck, 16> acks;

  // tick -> log writer
  SpscRing<LogRecord, 1024> log;  // ten seconds: a slow disk may block the writer for so long
};

}  // namespace sanso::firmware
