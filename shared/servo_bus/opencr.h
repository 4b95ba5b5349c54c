// Registers of the OP3's OpenCR board, which sits on the servo bus as a device of its own.
// Source: ROBOTIS OP3 device file of OpenCR and its firmware's register map.
#pragma once

#include <cstdint>

namespace sanso::servo_bus::opencr {

inline constexpr std::uint8_t kId = 200;
inline constexpr std::uint16_t kModel = 0x7400;  // 29696
// u8: 1 switches the servo supply on; without it no servo answers
inline constexpr std::uint16_t kServoPower = 24;
inline constexpr std::uint16_t kLed = 25;            // u8
inline constexpr std::uint16_t kButtons = 30;        // u8, bits below
inline constexpr std::uint16_t kVoltage = 31;        // u8, 0.1 V
inline constexpr std::uint16_t kGyro = 32;           // 3 x i16, 16.4 counts per deg/s
inline constexpr std::uint16_t kAccelerometer = 38;  // 3 x i16, 16384 counts per g
inline constexpr std::uint16_t kRollPitchYaw = 44;   // 3 x i16, 0.1 deg
inline constexpr std::uint16_t kImuControl = 50;     // u8
inline constexpr std::uint16_t kTableBytes = 51;

inline constexpr std::uint8_t kButtonMode = 0x01, kButtonStart = 0x02, kButtonUser = 0x04,
                              kButtonReset = 0x08;

inline constexpr double kGyroCountsPerDegPerSecond = 16.4;
inline constexpr double kAccelCountsPerG = 16384.0;

}  // namespace sanso::servo_bus::opencr
