// The library's chapters, one a file.
#pragma once

#include <vector>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {

std::vector<Effect> friction_effects();      // F
std::vector<Effect> transmission_effects();  // T
std::vector<Effect> mass_effects();          // M
std::vector<Effect> electrical_effects();    // E
std::vector<Effect> timing_effects();        // D
std::vector<Effect> sensor_effects();        // S
std::vector<Effect> contact_effects();       // C
std::vector<Effect> external_effects();      // X

using Theta = std::span<const double>;
inline JointParams& joint(SimParams& p, int where) {
  return p.joints[static_cast<std::size_t>(where)];
}
inline BodyInertia& body(SimParams& p, int where) {
  return p.tree.joints[static_cast<std::size_t>(where)].body;
}

inline constexpr Experiment kHalveGain{Experiment::Kind::setting,
                                       "halve the servo's P gain and repeat"};
inline constexpr Experiment kAddPayload{Experiment::Kind::setting,
                                        "attach a known payload and repeat"};
inline constexpr Experiment kTilt{Experiment::Kind::setting,
                                  "tilt the robot's base by 20 degrees and repeat"};
inline constexpr Experiment kRaiseSupply{Experiment::Kind::setting,
                                         "raise the supply by 1 V and repeat"};
inline constexpr Experiment kWarm{Experiment::Kind::setting, "repeat with a warm motor"};
inline constexpr Experiment kTorqueOff{Experiment::Kind::setting,
                                       "switch the torque off and let the joint swing"};
inline constexpr Experiment kLogCurrent{Experiment::Kind::channel, "record the motor current"};
inline constexpr Experiment kLogVoltage{Experiment::Kind::channel, "record the supply voltage"};
inline constexpr Experiment kLogDuty{Experiment::Kind::channel, "record the duty (PWM)"};
inline constexpr Experiment kOutsideSensor{Experiment::Kind::channel,
                                           "measure the link with a second sensor (IMU, camera)"};
inline constexpr Experiment kSlowRamps{Experiment::Kind::motion, "slow ramps in both directions"};
inline constexpr Experiment kLiftAndLower{Experiment::Kind::motion,
                                          "lift and lower the same load at the same speed"};
inline constexpr Experiment kAmplitudeSweep{Experiment::Kind::motion,
                                            "the same motion at three amplitudes"};
inline constexpr Experiment kChirp{Experiment::Kind::motion, "a sine of rising frequency"};
inline constexpr Experiment kSteps{Experiment::Kind::motion, "steps of three sizes"};
inline constexpr Experiment kFullRange{Experiment::Kind::motion,
                                       "one slow sweep over the whole range"};
inline constexpr Experiment kHolds{Experiment::Kind::motion,
                                   "holds of 1, 10 and 60 s between small motions"};
inline constexpr Experiment kPostures{Experiment::Kind::motion, "static holds in ten postures"};

}  // namespace sanso::diagnose
