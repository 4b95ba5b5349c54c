// The numbers of faults, limits and refusals. A fault latches and ends what the robot is doing; a
// limit informs and the robot carries on; a refusal answers a command or an upload. Each has a
// heading in docs/faults.md (a test compares).
#pragma once

#include <array>
#include <cstdint>

namespace sanso::firmware {

enum class Fault : std::uint16_t {
  none = 0,
  bus_silent = 10,
  servo_silent = 11,
  bus_gone = 12,
  power_switch = 13,
  servo_missing = 14,
  servo_model = 15,
  servo_register = 16,
  bus_foreign = 17,
  over_temperature = 20,
  overload = 21,
  servo_hardware = 22,
  under_voltage = 23,
  over_voltage = 24,
  torque_lost = 25,
  imu_silent = 30,
  imu_frozen = 31,
  imu_implausible = 32,
  fallen = 40,
  estimate = 41,
  emergency_stop = 42,
  tick_overrun = 50,
};

/// What the controller does with the servos when a fault latches.
enum class FaultReaction : std::uint8_t {
  hold,   // torque stays as it is, the last safe target is held
  lower,  // the robot is lowered into the crouch, then torque off
  limp,   // torque off: at once, or after a fall when the limbs are tucked
};

struct FaultInfo {
  Fault fault;
  const char* name;
  FaultReaction reaction;
};

inline constexpr std::array kFaults{
    FaultInfo{Fault::bus_silent, "bus_silent", FaultReaction::hold},
    FaultInfo{Fault::servo_silent, "servo_silent", FaultReaction::hold},
    FaultInfo{Fault::bus_gone, "bus_gone", FaultReaction::hold},
    FaultInfo{Fault::power_switch, "power_switch", FaultReaction::hold},
    FaultInfo{Fault::servo_missing, "servo_missing", FaultReaction::hold},
    FaultInfo{Fault::servo_model, "servo_model", FaultReaction::hold},
    FaultInfo{Fault::servo_register, "servo_register", FaultReaction::hold},
    FaultInfo{Fault::bus_foreign, "bus_foreign", FaultReaction::hold},
    FaultInfo{Fault::over_temperature, "over_temperature", FaultReaction::lower},
    FaultInfo{Fault::overload, "overload", FaultReaction::hold},
    FaultInfo{Fault::servo_hardware, "servo_hardware", FaultReaction::hold},
    FaultInfo{Fault::under_voltage, "under_voltage", FaultReaction::lower},
    FaultInfo{Fault::over_voltage, "over_voltage", FaultReaction::lower},
    FaultInfo{Fault::torque_lost, "torque_lost", FaultReaction::hold},
    FaultInfo{Fault::imu_silent, "imu_silent", FaultReaction::lower},
    FaultInfo{Fault::imu_frozen, "imu_frozen", FaultReaction::lower},
    FaultInfo{Fault::imu_implausible, "imu_implausible", FaultReaction::lower},
    FaultInfo{Fault::fallen, "fallen", FaultReaction::limp},
    FaultInfo{Fault::estimate, "estimate", FaultReaction::lower},
    FaultInfo{Fault::emergency_stop, "emergency_stop", FaultReaction::limp},
    FaultInfo{Fault::tick_overrun, "tick_overrun", FaultReaction::hold},
};

/// Bit numbers of Observation::limits.
enum class Limit : std::uint8_t {
  joint_range = 0,
  joint_rate = 1,
  servo_torque = 2,
  current = 3,
  temperature = 4,
  voltage = 5,
  upper_stale = 6,
  host_silent = 7,
  bus_loss = 8,
  pose_stale = 9,
  imu_late = 10,
  tilt = 11,
  late_tick = 12,
  upper_missing = 13,
  derated = 14,
};

struct LimitInfo {
  Limit limit;
  const char* name;
};

inline constexpr std::array kLimits{
    LimitInfo{Limit::joint_range, "joint_range"},
    LimitInfo{Limit::joint_rate, "joint_rate"},
    LimitInfo{Limit::servo_torque, "servo_torque"},
    LimitInfo{Limit::current, "current"},
    LimitInfo{Limit::temperature, "temperature"},
    LimitInfo{Limit::voltage, "voltage"},
    LimitInfo{Limit::upper_stale, "upper_stale"},
    LimitInfo{Limit::host_silent, "host_silent"},
    LimitInfo{Limit::bus_loss, "bus_loss"},
    LimitInfo{Limit::pose_stale, "pose_stale"},
    LimitInfo{Limit::imu_late, "imu_late"},
    LimitInfo{Limit::tilt, "tilt"},
    LimitInfo{Limit::late_tick, "late_tick"},
    LimitInfo{Limit::upper_missing, "upper_missing"},
    LimitInfo{Limit::derated, "derated"},
};

/// A set of limits, as it travels in Observation::limits.
class LimitSet {
 public:
  void add(Limit limit) { bits_ |= 1u << static_cast<unsigned>(limit); }
  void add_if(bool condition, Limit limit) {
    if (condition) add(limit);
  }
  bool has(Limit limit) const { return (bits_ & (1u << static_cast<unsigned>(limit))) != 0; }
  std::uint32_t bits() const { return bits_; }

 private:
  std::uint32_t bits_ = 0;
};

/// Why a command or an upload was refused: `reason` of its acknowledgement.
enum class Refusal : std::uint16_t {
  none = 0,
  wrong_state = 100,
  no_primitives = 101,
  stale_table = 102,
  not_upright = 103,
  start_pose = 104,
  torque_on = 105,
  servo_not_fresh = 106,
  imu_not_fresh = 107,
  joint_range = 108,
  goals_unconfirmed = 109,
  upload_checksum = 110,
  upload_contents = 111,
  upload_size = 112,
  torque_unconfirmed = 120,
  no_realtime = 121,
  hot_or_low = 122,
  ending = 123,
  stale_command = 124,
  not_owner = 125,
};

struct RefusalInfo {
  Refusal refusal;
  const char* name;
};

inline constexpr std::array kRefusals{
    RefusalInfo{Refusal::wrong_state, "wrong_state"},
    RefusalInfo{Refusal::no_primitives, "no_primitives"},
    RefusalInfo{Refusal::stale_table, "stale_table"},
    RefusalInfo{Refusal::not_upright, "not_upright"},
    RefusalInfo{Refusal::start_pose, "start_pose"},
    RefusalInfo{Refusal::torque_on, "torque_on"},
    RefusalInfo{Refusal::servo_not_fresh, "servo_not_fresh"},
    RefusalInfo{Refusal::imu_not_fresh, "imu_not_fresh"},
    RefusalInfo{Refusal::joint_range, "joint_range"},
    RefusalInfo{Refusal::goals_unconfirmed, "goals_unconfirmed"},
    RefusalInfo{Refusal::upload_checksum, "upload_checksum"},
    RefusalInfo{Refusal::upload_contents, "upload_contents"},
    RefusalInfo{Refusal::upload_size, "upload_size"},
    RefusalInfo{Refusal::torque_unconfirmed, "torque_unconfirmed"},
    RefusalInfo{Refusal::no_realtime, "no_realtime"},
    RefusalInfo{Refusal::hot_or_low, "hot_or_low"},
    RefusalInfo{Refusal::ending, "ending"},
    RefusalInfo{Refusal::stale_command, "stale_command"},
    RefusalInfo{Refusal::not_owner, "not_owner"},
};

constexpr const FaultInfo* info_of(Fault fault) {
  for (const FaultInfo& info : kFaults)
    if (info.fault == fault) return &info;
  return nullptr;
}
constexpr FaultReaction reaction_of(Fault fault) {
  return info_of(fault) != nullptr ? info_of(fault)->reaction : FaultReaction::hold;
}
constexpr const char* name_of(Fault fault) {
  return info_of(fault) != nullptr ? info_of(fault)->name : "none";
}
constexpr const char* name_of(Refusal refusal) {
  for (const RefusalInfo& info : kRefusals)
    if (info.refusal == refusal) return info.name;
  return "none";
}

}  // namespace sanso::firmware
