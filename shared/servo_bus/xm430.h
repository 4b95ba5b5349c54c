// Control table of the XM430-W350: where every register lies, who may write it, its raw range and
// initial value.
// Source: ROBOTIS e-Manual, XM430-W350-R (firmware 45). Units are in units.h; raw values stay in
// this folder's callers that build packets. Addresses below 64 are EEPROM: writable only while
// Torque Enable is 0.
#pragma once

#include <array>
#include <cstdint>

#include "shared/servo_bus/packet.h"

namespace sanso::servo_bus {

enum class Access : std::uint8_t { read, read_write };

struct Register {
  std::uint16_t address = 0;
  std::uint8_t size = 0;  // bytes
  Access access = Access::read;
  bool is_signed = false;
  std::int64_t initial_raw = 0;
  std::int64_t min_raw = 0;  // of a write
  std::int64_t max_raw = 0;
  const char* name = "";
};

namespace xm430 {

inline constexpr std::uint16_t kModel = 1020;
inline constexpr std::uint8_t kFirmwareWithFastRead = 45;  // fast sync read needs at least this
inline constexpr std::uint16_t kFirstRamAddress = 64;
inline constexpr std::uint16_t kTableBytes = 662;

inline constexpr Register kModelNumber{0, 2, Access::read, false, 1020, 0, 65535, "Model Number"};
inline constexpr Register kModelInformation{2, 4, Access::read, false,
                                            0, 0, 4294967295,   "Model Information"};
inline constexpr Register kFirmwareVersion{6, 1, Access::read, false,
                                           0, 0, 255,          "Firmware Version"};
inline constexpr Register kId{7, 1, Access::read_write, false, 1, 0, 252, "ID"};
inline constexpr Register kBaudRate{8, 1, Access::read_write, false, 1, 0, 7, "Baud Rate"};
inline constexpr Register kReturnDelayTime{9, 1,   Access::read_write, false, 250,
                                           0, 254, "Return Delay Time"};
inline constexpr Register kDriveMode{10, 1, Access::read_write, false, 0, 0, 13, "Drive Mode"};
inline constexpr Register kOperatingMode{11, 1,  Access::read_write, false, 3,
                                         0,  16, "Operating Mode"};
inline constexpr Register kSecondaryId{12, 1,   Access::read_write, false, 255,
                                       0,  255, "Secondary ID"};
inline constexpr Register kProtocolType{13, 1, Access::read_write, false, 2, 1, 2, "Protocol Type"};
inline constexpr Register kHomingOffset{20,       4,       Access::read_write, true, 0,
                                        -1044479, 1044479, "Homing Offset"};
inline constexpr Register kMovingThreshold{24, 4,    Access::read_write, false, 10,
                                           0,  1023, "Moving Threshold"};
inline constexpr Register kTemperatureLimit{31, 1,   Access::read_write, false, 80,
                                            0,  100, "Temperature Limit"};
inline constexpr Register kMaxVoltageLimit{32, 2,   Access::read_write, false, 160,
                                           95, 160, "Max Voltage Limit"};
inline constexpr Register kMinVoltageLimit{34, 2,   Access::read_write, false, 95,
                                           95, 160, "Min Voltage Limit"};
inline constexpr Register kPwmLimit{36, 2, Access::read_write, false, 885, 0, 885, "PWM Limit"};
inline constexpr Register kCurrentLimit{38, 2,    Access::read_write, false, 1193,
                                        0,  1193, "Current Limit"};
inline constexpr Register kAccelerationLimit{40, 4,     Access::read_write,  false, 32767,
                                             0,  32767, "Acceleration Limit"};
inline constexpr Register kVelocityLimit{44, 4,    Access::read_write, false, 200,
                                         0,  1023, "Velocity Limit"};
inline constexpr Register kMaxPositionLimit{48, 4,    Access::read_write,  false, 4095,
                                            0,  4095, "Max Position Limit"};
inline constexpr Register kMinPositionLimit{52, 4,    Access::read_write,  false, 0,
                                            0,  4095, "Min Position Limit"};
inline constexpr Register kStartupConfiguration{60, 1, Access::read_write,     false, 0,
                                                0,  3, "Startup Configuration"};
inline constexpr Register kShutdown{63, 1, Access::read_write, false, 52, 0, 63, "Shutdown"};
inline constexpr Register kTorqueEnable{64, 1, Access::read_write, false, 0, 0, 1, "Torque Enable"};
inline constexpr Register kLed{65, 1, Access::read_write, false, 0, 0, 1, "LED"};
inline constexpr Register kStatusReturnLevel{68, 1, Access::read_write,   false, 2,
                                             0,  2, "Status Return Level"};
inline constexpr Register kRegisteredInstruction{
    69, 1, Access::read, false, 0, 0, 1, "Registered Instruction"};
inline constexpr Register kHardwareErrorStatus{70, 1, Access::read, false,
                                               0,  0, 63,           "Hardware Error Status"};
inline constexpr Register kVelocityIGain{76, 2,     Access::read_write, false, 1920,
                                         0,  16383, "Velocity I Gain"};
inline constexpr Register kVelocityPGain{78, 2,     Access::read_write, false, 100,
                                         0,  16383, "Velocity P Gain"};
inline constexpr Register kPositionDGain{80, 2,     Access::read_write, false, 0,
                                         0,  16383, "Position D Gain"};
inline constexpr Register kPositionIGain{82, 2,     Access::read_write, false, 0,
                                         0,  16383, "Position I Gain"};
inline constexpr Register kPositionPGain{84, 2,     Access::read_write, false, 800,
                                         0,  16383, "Position P Gain"};
inline constexpr Register kFeedforwardAccelerationGain{88, 2,     Access::read_write,    false, 0,
                                                       0,  16383, "Feedforward 2nd Gain"};
inline constexpr Register kFeedforwardVelocityGain{90, 2,     Access::read_write,    false, 0,
                                                   0,  16383, "Feedforward 1st Gain"};
inline constexpr Register kBusWatchdog{98, 1, Access::read_write, true, 0, -1, 127, "Bus Watchdog"};
inline constexpr Register kGoalPwm{100, 2, Access::read_write, true, 885, -885, 885, "Goal PWM"};
inline constexpr Register kGoalCurrent{102,   2,    Access::read_write, true, 1193,
                                       -1193, 1193, "Goal Current"};
inline constexpr Register kGoalVelocity{104,   4,    Access::read_write, true, 0,
                                        -1023, 1023, "Goal Velocity"};
inline constexpr Register kProfileAcceleration{108, 4,     Access::read_write,    false, 0,
                                               0,   32767, "Profile Acceleration"};
inline constexpr Register kProfileVelocity{112, 4,     Access::read_write, false, 0,
                                           0,   32767, "Profile Velocity"};
inline constexpr Register kGoalPosition{116,      4,       Access::read_write, true, 2048,
                                        -1048575, 1048575, "Goal Position"};
inline constexpr Register kRealtimeTick{120, 2, Access::read, false, 0, 0, 32767, "Realtime Tick"};
inline constexpr Register kMoving{122, 1, Access::read, false, 0, 0, 1, "Moving"};
inline constexpr Register kMovingStatus{123, 1, Access::read, false, 0, 0, 255, "Moving Status"};
inline constexpr Register kPresentPwm{124, 2, Access::read, true, 0, -885, 885, "Present PWM"};
inline constexpr Register kPresentCurrent{126, 2,     Access::read, true,
                                          0,   -1193, 1193,         "Present Current"};
inline constexpr Register kPresentVelocity{128, 4,     Access::read, true,
                                           0,   -1023, 1023,         "Present Velocity"};
inline constexpr Register kPresentPosition{132, 4,        Access::read, true,
                                           0,   -1048575, 1048575,      "Present Position"};
inline constexpr Register kVelocityTrajectory{
    136, 4, Access::read, true, 0, -2147483648, 2147483647, "Velocity Trajectory"};
inline constexpr Register kPositionTrajectory{
    140, 4, Access::read, true, 0, -2147483648, 2147483647, "Position Trajectory"};
inline constexpr Register kPresentInputVoltage{144, 2, Access::read, false,
                                               0,   0, 65535,        "Present Input Voltage"};
inline constexpr Register kPresentTemperature{146, 1, Access::read, false,
                                              0,   0, 255,          "Present Temperature"};
inline constexpr Register kBackupReady{147, 1, Access::read, false, 0, 0, 1, "Backup Ready"};

// Indirect Address n points at a byte in 64..661; Indirect Data n then reads and writes that byte.
// Entries 1..28, 29..56.
inline constexpr std::uint16_t kIndirectAddress1 = 168, kIndirectData1 = 224;
inline constexpr std::uint16_t kIndirectAddress29 = 578, kIndirectData29 = 634;
inline constexpr int kIndirectPerBlock = 28;

/// All registers but the indirect ones, by address.
inline constexpr std::array kRegisters{kModelNumber,
                                       kModelInformation,
                                       kFirmwareVersion,
                                       kId,
                                       kBaudRate,
                                       kReturnDelayTime,
                                       kDriveMode,
                                       kOperatingMode,
                                       kSecondaryId,
                                       kProtocolType,
                                       kHomingOffset,
                                       kMovingThreshold,
                                       kTemperatureLimit,
                                       kMaxVoltageLimit,
                                       kMinVoltageLimit,
                                       kPwmLimit,
                                       kCurrentLimit,
                                       kAccelerationLimit,
                                       kVelocityLimit,
                                       kMaxPositionLimit,
                                       kMinPositionLimit,
                                       kStartupConfiguration,
                                       kShutdown,
                                       kTorqueEnable,
                                       kLed,
                                       kStatusReturnLevel,
                                       kRegisteredInstruction,
                                       kHardwareErrorStatus,
                                       kVelocityIGain,
                                       kVelocityPGain,
                                       kPositionDGain,
                                       kPositionIGain,
                                       kPositionPGain,
                                       kFeedforwardAccelerationGain,
                                       kFeedforwardVelocityGain,
                                       kBusWatchdog,
                                       kGoalPwm,
                                       kGoalCurrent,
                                       kGoalVelocity,
                                       kProfileAcceleration,
                                       kProfileVelocity,
                                       kGoalPosition,
                                       kRealtimeTick,
                                       kMoving,
                                       kMovingStatus,
                                       kPresentPwm,
                                       kPresentCurrent,
                                       kPresentVelocity,
                                       kPresentPosition,
                                       kVelocityTrajectory,
                                       kPositionTrajectory,
                                       kPresentInputVoltage,
                                       kPresentTemperature,
                                       kBackupReady};

// Hardware Error Status (70) and Shutdown (63).
inline constexpr std::uint8_t kErrorVoltage = 0x01, kErrorOverheat = 0x04, kErrorEncoder = 0x08,
                              kErrorShock = 0x10, kErrorOverload = 0x20;

// Operating Mode (11).
inline constexpr std::uint8_t kModePosition = 3;

inline constexpr std::array<std::int32_t, 8> kBaudRates{9600, 57600, 115200, 1'000'000, 2'000'000,
                                                        // index: Baud Rate (8)
                                                        3'000'000, 4'000'000, 4'500'000};

/// What a policy reads every tick: current, velocity and position lie together.
inline constexpr std::uint16_t kFeedbackAddress = 126;
inline constexpr std::uint16_t kFeedbackBytes = 10;

struct Feedback {
  std::int16_t current_raw = 0;
  std::int32_t velocity_raw = 0;
  std::int32_t position_raw = 0;
};

/// `data`: kFeedbackBytes bytes read from kFeedbackAddress.
constexpr Feedback decode_feedback(std::span<const std::uint8_t> data) {
  return {get_i16(data), get_i32(data.subspan(2)), get_i32(data.subspan(6))};
}

}  // namespace xm430
}  // namespace sanso::servo_bus
