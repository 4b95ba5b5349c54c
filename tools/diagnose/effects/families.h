// The library's chapters, one a file, and what their effects are made of: what a chapter shares,
// the plain ways of changing a joint, experiments.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <utility>
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

/// What the effects of a chapter have in common.
struct Chapter {
  Family family{};
  Port port{};
  Scope scope{};
  unsigned residuals = 0;
};
inline Effect of_chapter(const Chapter& chapter, Effect effect) {
  effect.family = chapter.family;
  effect.port = chapter.port;
  effect.scope = chapter.scope;
  if (effect.residuals == 0) effect.residuals = chapter.residuals;
  return effect;
}

/// Parameter k is added to the k-th field.
template <class... Field>
auto adds(Field JointParams::*... field) {
  return [=](SimParams& p, int j, Theta x) {
    std::size_t k = 0;
    ((joint(p, j).*field += x[k++]), ...);
  };
}
/// The k-th field is multiplied by parameter k.
template <class... Field>
auto multiplies(Field JointParams::*... field) {
  return [=](SimParams& p, int j, Theta x) {
    std::size_t k = 0;
    ((joint(p, j).*field *= x[k++]), ...);
  };
}
/// Parameters sine, cosine, order replace a ripple; without an amplitude they leave it alone.
inline auto ripples(Ripple JointParams::*field) {
  return [=](SimParams& p, int j, Theta x) {
    if (x[0] == 0.0 && x[1] == 0.0) return;
    joint(p, j).*field = {x[0], x[1], x[2]};
  };
}

/// The key of model.toml to which a parameter is added.
inline SettingChange added_to(double JointSettings::*key) {
  return {SettingChange::How::added, {key}};
}
/// The keys that a parameter multiplies, all or of one kind of actuator.
inline SettingChange multiplied(std::vector<double JointSettings::*> keys,
                                std::optional<Actuator> only = {}) {
  return {SettingChange::How::multiplied, std::move(keys), only};
}

/// Parameters change by `parameters` for one unit, at every joint.
inline auto everywhere(std::vector<double> parameters) {
  return [parameters = std::move(parameters)](const SimParams&, std::size_t) { return parameters; };
}
/// The same at the joints of some actuators.
inline auto driven_by(std::vector<Actuator> actuators, std::vector<double> parameters) {
  return [actuators = std::move(actuators), parameters = std::move(parameters)](const SimParams& p,
                                                                                std::size_t j) {
    const Actuator here = p.joints[j].nominal.actuator;
    const bool listed = std::find(actuators.begin(), actuators.end(), here) != actuators.end();
    return listed ? parameters : std::vector<double>{};
  };
}
/// The setting's own value is the unit, where the model states one.
inline auto as_stated(double JointSettings::*key) {
  return [=](const SimParams& p, std::size_t j) {
    const double stated = p.joints[j].nominal.*key;
    return stated > 0.0 ? std::vector<double>{stated} : std::vector<double>{};
  };
}

/// 1 at a joint that turns: the tolerance is one of angles, and a slide has none.
inline double where_it_turns(const SimParams& p, std::size_t j) {
  return p.tree.joints[j].prismatic ? 0.0 : 1.0;
}

/// A tolerance of an effort: of what the model states, or (no key) of one.
inline EffortTolerance within(int order, double ToleranceSettings::*deviation,
                              double JointSettings::*stated = nullptr) {
  return {order, deviation, [stated](const SimParams& p, std::size_t j) {
            return stated == nullptr ? 1.0 : p.joints[j].nominal.*stated;
          }};
}

/// Probes of a ripple: sine and cosine of one size at each order.
inline std::vector<std::vector<double>> both_phases(double size,
                                                    std::initializer_list<double> orders) {
  std::vector<std::vector<double>> probes;
  for (const double order : orders) {
    probes.push_back({size, 0.0, order});
    probes.push_back({0.0, size, order});
  }
  return probes;
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
