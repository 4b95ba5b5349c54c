// Units, by consistency between channels and with what the machine can do. Never by a guess about
// one number.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/gate/noise.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/smoother.h"

namespace sanso::diagnose::gate {
namespace {

bool near_factor(double ratio, double factor) {
  return ratio > 0.75 * factor && ratio < 1.33 * factor;
}

std::string name_of_factor(double ratio) {
  if (near_factor(ratio, kDegree)) return "degrees instead of radians";
  if (near_factor(ratio, 1000.0)) return "thousandths of the unit (ms, mm, mA or mrad)";
  return fmt::format("a unit {:.3g} times too small", ratio);
}

/// Slope of y on x through the medians' spread: scale ratio of two channels that should be equal; 0
/// when they do not agree.
double scale_ratio(std::span<const double> x, std::span<const double> y,
                   const GateSettings& settings) {
  if (std::abs(correlation(x, y)) < settings.answers) return 0.0;
  const double sx = standard_deviation(x), sy = standard_deviation(y);
  return sx > 0.0 ? sy / sx : 0.0;
}

std::optional<Defect> check_time_unit(const GateRecording& r) {
  const double interval = sampling_interval(r.t);
  // a controller slower than 2 Hz or faster than 100 kHz does not control a robot joint
  if (interval > 0.5) {
    return Defect{
        r.file, "t", -1, defect::kWrongUnit,
        fmt::format("{:.4g} s between samples; is t in milliseconds? expected seconds", interval)};
  }
  if (interval > 0.0 && interval < 1e-5) {
    return Defect{r.file, "t", -1, defect::kWrongUnit,
                  fmt::format("{:.4g} s between samples; expected seconds", interval)};
  }
  return std::nullopt;
}

/// Position against velocity: the integral of dq must span what q spans.
std::optional<Defect> check_velocity_unit(const GateRecording& r, const GateJoint& joint,
                                          const GateChannel& q, const GateSettings& settings) {
  const GateChannel* dq = r.find("dq:" + joint.name);
  if (dq == nullptr) return std::nullopt;
  const std::vector<double> position = without_glitches(q.values, nullptr, settings);
  std::vector<double> difference, velocity;
  // over stretches of ~50 ms: longer than the quantisation of either channel, shorter than a swing
  const double interval = sampling_interval(r.t);
  const auto stride =
      std::max<std::size_t>(1, static_cast<std::size_t>(0.05 / std::max(interval, 1e-6)));
  for (std::size_t i = 0; i + stride < position.size(); i += stride) {
    double sum = 0.0;
    std::size_t n = 0;
    for (std::size_t k = i; k <= i + stride; ++k) {
      if (std::isfinite(dq->values[k])) sum += dq->values[k], ++n;
    }
    if (n == 0 || !std::isfinite(position[i]) || !std::isfinite(position[i + stride])) continue;
    difference.push_back((position[i + stride] - position[i]) / (r.t[i + stride] - r.t[i]));
    velocity.push_back(sum / static_cast<double>(n));
  }
  const double ratio = scale_ratio(velocity, difference, settings);
  if (ratio == 0.0) return std::nullopt;
  if (correlation(velocity, difference) < 0.0) {
    return Defect{r.file, dq->name, -1, defect::kWrongSign,
                  "velocity runs against the change of position; expected dq = d(q)/dt"};
  }
  if (ratio > settings.wrong_unit || ratio < 1.0 / settings.wrong_unit) {
    const bool q_large = ratio > 1.0;
    return Defect{r.file, q_large ? q.name : dq->name, -1, defect::kWrongUnit,
                  fmt::format("d(q)/dt is {:.4g} times dq: {}", ratio,
                              name_of_factor(q_large ? ratio : 1.0 / ratio))};
  }
  return std::nullopt;
}

/// Position against command: same unit, or the slope betrays it.
std::optional<Defect> check_command_unit(const GateRecording& r, const GateJoint& joint,
                                         const GateChannel& q, const GateSettings& settings) {
  const GateChannel* u = r.find("u:" + joint.name);
  if (u == nullptr) return std::nullopt;
  const double ratio = scale_ratio(u->values, q.values, settings);
  if (ratio == 0.0 || (ratio < settings.wrong_unit && ratio > 1.0 / settings.wrong_unit))
    return std::nullopt;
  const bool q_large = ratio > 1.0;
  return Defect{r.file, q_large ? q.name : u->name, -1, defect::kWrongUnit,
                fmt::format("q moves {:.4g} times as far as u: {}", ratio,
                            name_of_factor(q_large ? ratio : 1.0 / ratio))};
}

/// Against the machine: joint limits, reachable speed, and the encoder's own step (360 / 2^k
/// degrees).
std::optional<Defect> check_position_scale(const GateRecording& r, const GateJoint& joint,
                                           const GateChannel& q, const GateSettings& settings) {
  if (joint.prismatic) {
    const double span = joint.upper - joint.lower;
    const double range = quantile(q.values, 1.0) - quantile(q.values, 0.0);
    if (span > 0.0 && range > settings.wrong_unit * span) {
      return Defect{r.file, q.name, -1, defect::kWrongUnit,
                    fmt::format("moves over {:.4g}, limits allow {:.4g} m; is it in millimetres?",
                                range, span)};
    }
    return std::nullopt;
  }
  const double range = quantile(q.values, 0.999) - quantile(q.values, 0.001);
  const double quantum = quantisation_step(q.values);
  bool degree_steps = false;
  for (int bits = 10; quantum > 0.0 && bits <= 20; ++bits) {
    degree_steps |= std::abs(quantum / (360.0 / std::ldexp(1.0, bits)) - 1.0) < 2e-3;
  }
  std::vector<double> speed;
  for (std::size_t i = 4; i < q.values.size(); i += 4) {
    const double v = (q.values[i] - q.values[i - 4]) / (r.t[i] - r.t[i - 4]);
    if (std::isfinite(v)) speed.push_back(std::abs(v));
  }
  const double fast = quantile(speed, 0.95);
  const double span = joint.upper - joint.lower;
  std::string why;
  if (span > 0.0 && span < 4.0 * std::numbers::pi && range > 3.0 * span) {
    why = fmt::format("moves over {:.4g}, limits allow {:.4g} rad", range, span);
  } else if (joint.speed_limit > 0.0 && fast > 5.0 * joint.speed_limit) {
    why = fmt::format("reaches {:.4g} per second, the motor at most {:.4g} rad/s", fast,
                      joint.speed_limit);
  } else if (degree_steps) {
    why = fmt::format("steps of {:.6g} are an encoder's steps in degrees", quantum);
  } else {
    return std::nullopt;
  }
  return Defect{r.file, q.name, -1, defect::kWrongUnit, why + ": degrees? expected radians"};
}

/// Electrical channels against the data sheet.
std::optional<Defect> check_magnitude(const GateRecording& r, const std::string& channel,
                                      double expected, const char* unit,
                                      const GateSettings& settings) {
  const GateChannel* c = r.find(channel);
  if (c == nullptr || expected <= 0.0) return std::nullopt;
  const double high =
      std::max(std::abs(quantile(c->values, 0.99)), std::abs(quantile(c->values, 0.01)));
  if (std::isfinite(high) && high > settings.wrong_unit * expected) {
    return Defect{r.file, channel, -1, defect::kWrongUnit,
                  fmt::format("reaches {:.4g}; the model allows {:.4g} {}: thousandths?", high,
                              expected, unit)};
  }
  return std::nullopt;
}

}  // namespace

std::vector<Defect> check_units(const GateRecording& r, const Joints& joints,
                                const GateSettings& settings) {
  std::vector<Defect> out;
  append(out, check_time_unit(r));
  for (const GateJoint& joint : joints) {
    const GateChannel* q = r.find("q:" + joint.name);
    if (q == nullptr) continue;
    std::optional<Defect> found = check_position_scale(r, joint, *q, settings);
    if (!found) found = check_command_unit(r, joint, *q, settings);
    if (!found) found = check_velocity_unit(r, joint, *q, settings);
    if (found && found->defect == defect::kWrongSign)
      append_either(out, r, joint, std::move(found));
    else
      append(out, std::move(found));
    append(out, check_magnitude(r, "i:" + joint.name, joint.current_limit, "A", settings));
    append(out, check_magnitude(r, "tau:" + joint.name, joint.torque_limit, "N m", settings));
    append(out, check_magnitude(r, "tau_cmd:" + joint.name, joint.torque_limit, "N m", settings));
    const GateChannel* temperature = r.find("temp:" + joint.name);
    if (temperature != nullptr && quantile(temperature->values, 0.5) > 200.0) {
      out.push_back({r.file, temperature->name, -1, defect::kWrongUnit,
                     "above 200; expected degrees Celsius, not kelvin"});
    }
  }
  if (!joints.empty())
    append(out, check_magnitude(r, "volt", joints.front().voltage, "V", settings));
  return out;
}

}  // namespace sanso::diagnose::gate
