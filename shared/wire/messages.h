// The messages between host and controller, as plain values. Their bytes are made and read in
// codec.h; docs/wire.md lists every field. A message that does not decode completely is no message.
#pragma once

#include <array>
#include <cstdint>

#include "shared/base/fixed_vector.h"
#include "shared/base/time.h"
#include "shared/model/state_layout.h"
#include "shared/policy/policy_types.h"

namespace sanso::wire {

inline constexpr std::uint8_t kProtocolVersion = 2;
inline constexpr std::size_t kMaxDatagram = 1400;

enum class MessageType : std::uint8_t {
  hello = 1,        // both ways: opens a session (nonces, versions)
  observation = 2,  // controller -> host, every tick
  // host -> controller: a piece of a primitive set, a middle table or an upper policy
  upload_chunk = 3,
  upload_ack = 4,   // controller -> host: what of an upload is complete, and its checksum
  command = 5,      // host -> controller
  command_ack = 6,  // controller -> host
  // not sealed: who is there, for people before whom everything else stays silent
  who = 7,   // anyone -> controller
  i_am = 8,  // controller -> anyone
};

enum class SupervisorState : std::uint8_t {
  boot = 0,
  self_test = 1,
  idle = 2,
  stand_up = 3,
  hold = 4,
  run = 5,
  soft_stop = 6,
  fault = 7,
};

/// What the host may ask for. A command that the present state does not allow is refused in its
/// acknowledgement.
enum class CommandKind : std::uint8_t {
  none = 0,
  // idle -> (torque on, present = goal) stand_up -> hold in the first pose of the uploaded
  // primitives
  arm = 1,
  start_trial = 2,  // hold -> run: trial clock 0 is the next tick
  stop = 3,         // run -> soft_stop -> hold
  disarm = 4,       // hold | soft_stop -> idle (torque off after lowering to the safe posture)
  clear_fault = 5,  // fault -> self_test; refused while the servos hold the robot
  lower = 6,        // from wherever torque is on, a latched fault included: down, then torque off
  emergency_stop = 7,  // from anywhere: torque off at once, latched as a fault
};

struct Command {
  // acknowledged by number; repeated until acknowledged, executed once
  std::uint32_t sequence = 0;
  CommandKind kind = CommandKind::none;
  std::uint32_t trial_id = 0;
  std::uint8_t layers = policy::LayerSwitches::kAll;  // LayerSwitches::mask()
  // start_trial: the controller ends the trial by itself after this many ticks
  std::int32_t duration_ticks = 0;
  // tick of the newest observation that the sender has seen: a command that was long on its way is
  // refused (R124); an emergency stop never is
  std::uint64_t observed_tick = 0;
};
/// A command is good for this long after the observation that it answers.
inline constexpr std::uint64_t kCommandLife_ticks = 50;
/// A host that owns the session keeps it for this long after its last datagram.
inline constexpr Nanoseconds kOwnerLease = 2 * kSecond;

struct CommandAck {
  std::uint32_t sequence = 0;
  std::uint8_t accepted = 0;
  SupervisorState state = SupervisorState::boot;
  std::uint16_t reason = 0;  // fault or refusal number, docs/faults.md
};

enum class UploadKind : std::uint8_t { primitives = 1, middle_table = 2, upper_policy = 3 };

/// Controller -> host at every tick.
struct Observation {
  std::uint64_t tick = 0;        // since boot
  Nanoseconds time = 0;          // controller clock at the start of the tick
  std::int32_t trial_tick = -1;  // tick of the running trial; -1 outside
  std::uint32_t trial_id = 0;
  SupervisorState state = SupervisorState::boot;
  std::uint16_t fault = 0;            // latched fault number, 0 = none
  std::uint32_t limits = 0;           // bit set of Limit (faults.md), this tick
  std::uint8_t contact = 0;           // bit 0 right, bit 1 left sole loaded (estimator's belief)
  std::uint8_t pose_age_ticks = 255;  // age of the last external pose sample; 255 = none
  model::State x = model::neutral_state();                    // estimate
  std::array<std::int16_t, model::kNumJoints> current_raw{};  // 2.69 mA
  std::array<double, 3> imu_acc{};                            // base axes, m/s^2
  std::array<double, 3> imu_gyro{};                           // base axes, rad/s
  float voltage_V = 0;
  float max_temperature_C = 0;
  std::uint32_t upper_sequence = 0;   // sequence of the upper policy in use
  std::int16_t upper_age_ticks = -1;  // ticks since its last knot; below 0: still inside its span
  float upper_weight = 0;             // 1 = full, falls to 0 as a stale policy fades out
  model::Input u_upper = model::Input::Zero();  // rad, u_up + K_up (x - x_up), after the fade
  model::Input u_middle = model::Input::Zero();
  model::Input u_lower = model::Input::Zero();  // primitives and reflex
  model::Input u_out = model::Input::Zero();    // what was sent to the servos, after the guard
  std::uint32_t tick_cpu_ns = 0;
  std::uint32_t late_ticks = 0;         // ticks that missed their deadline, since boot
  std::uint32_t bus_lost = 0;           // servo replies missing, since boot
  std::uint32_t bus_corrupt = 0;        // servo replies damaged, since boot
  std::uint32_t datagrams_dropped = 0;  // malformed, replayed, forged, stale
};

/// Answer to `who`: what a host needs to know when its key or its version do not fit.
struct Identity {
  std::uint8_t protocol_version = kProtocolVersion;
  std::array<char, 32> robot_name{};  // printable, zeros behind
};

/// A piece of an upload. Pieces may come in any order and more than once; the whole counts only
/// when its checksum fits.
inline constexpr std::size_t kChunkPayload = 1280;
struct UploadChunk {
  UploadKind kind = UploadKind::primitives;
  std::uint32_t upload_id = 0;  // new for every upload of a kind
  std::uint32_t total_bytes = 0;
  std::uint32_t checksum = 0;  // CRC-32 of the whole
  std::uint16_t index = 0;
  std::uint16_t count = 0;
  FixedVector<std::uint8_t, kChunkPayload> payload;
};

struct UploadAck {
  UploadKind kind = UploadKind::primitives;
  std::uint32_t upload_id = 0;
  std::uint8_t complete = 0;  // 1: whole, checksum right, contents valid
  std::uint8_t refused = 0;   // 1: whole but invalid; `reason` says why
  std::uint16_t reason = 0;
  std::uint16_t first_missing = 0;
};

}  // namespace sanso::wire
