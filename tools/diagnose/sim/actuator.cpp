// One function a kind of actuator. Each also gives the slope of the torque by the motor's speed,
// for the implicit step.
#include "tools/diagnose/sim/actuator.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

double limit_or_none(double setting) { return setting > 0.0 ? setting : kNone; }

/// Velocity and acceleration limits of the goal, as a servo with an internal profile follows it.
CommandPath::Command profiled(const JointParams& joint, const ServoInput& in, InnerState& inner) {
  CommandPath::Command command = in.command;
  if (joint.profile_speed == kNone && joint.profile_acceleration == kNone) return command;
  if (!inner.profile_set) {
    inner.profile = in.position;
    inner.profile_speed = 0.0;
    inner.profile_set = true;
  }
  const double ahead = command.value - inner.profile;
  double speed = std::min(std::abs(ahead) / in.h, joint.profile_speed);
  if (joint.profile_acceleration != kNone) {
    // able to stop at the goal
    speed = std::min(speed, std::sqrt(2.0 * joint.profile_acceleration * std::abs(ahead)));
    const double change = joint.profile_acceleration * in.h;
    inner.profile_speed +=
        std::clamp(std::copysign(speed, ahead) - inner.profile_speed, -change, change);
  } else {
    inner.profile_speed = std::copysign(speed, ahead);
  }
  inner.profile += in.h * inner.profile_speed;
  command.value = inner.profile;
  command.rate = inner.profile_speed;
  return command;
}

/// Dead zone, first-order filter and limit of a controller's output; `slope` becomes d output / d
/// raw.
double shaped(const JointParams& joint, double raw, double full, double limit, double h,
              InnerState& inner, double& slope) {
  slope = 1.0;
  if (joint.dead_zone > 0.0 && full < kNone) {
    const double zone = joint.dead_zone * full;
    slope = std::abs(raw) > zone ? 1.0 : 0.0;
    raw = std::abs(raw) > zone ? raw - std::copysign(zone, raw) : 0.0;
  }
  if (joint.output_filter > 0.0) {
    const double gain = h / (joint.output_filter + h);
    inner.filtered += gain * (raw - inner.filtered);
    raw = inner.filtered;
    slope *= gain;
  }
  if (std::abs(raw) > limit) {
    slope = 0.0;
    raw = std::copysign(limit, raw);
  }
  return raw;
}

/// Controller common to dc_servo (gains in duty) and position_pd (gains in torque).
struct Gains {
  double p, d, i;  // output per rad, per rad/s, per rad s
};
double controller(const JointParams& joint, const Gains& gains, const ServoInput& in,
                  const CommandPath::Command& goal, double limit, InnerState& inner) {
  const double error = goal.value - in.position;
  const double without_integral =
      gains.p * error - gains.d * in.velocity + gains.p * joint.feed_forward * goal.rate;
  if (gains.i <= 0.0) return without_integral;
  const double integral = inner.integral + in.h * error;
  // at the limit the integral may only move back, or go on as far as the firmware lets it wind up
  if (std::abs(without_integral + gains.i * integral) < limit || error * inner.integral < 0.0 ||
      gains.i * std::abs(integral) < joint.windup * limit)
    inner.integral = integral;
  return without_integral + gains.i * inner.integral;
}

ServoOutput dc_servo(const JointParams& joint, const ServoInput& in, InnerState& inner) {
  const JointSettings& s = joint.nominal;
  ServoOutput out;
  out.volt = s.voltage * in.supply - in.supply_drop;
  const double warm = std::max(0.0, 1.0 - joint.derating * in.warming);
  const double torque_constant = s.torque_constant * joint.torque_scale * warm;
  const double back_emf = s.back_emf * joint.torque_scale;
  const double resistance = s.resistance * joint.resistance_scale;

  const double limit = std::min(s.duty_limit, joint.output_limit);
  const double nominal_stall = s.torque_constant * s.voltage / s.resistance;  // N m per duty
  const double added_d =
      joint.d_torque != 0.0 && nominal_stall > 0.0 ? joint.d_torque / nominal_stall : 0.0;
  const double p = s.p_gain * joint.p_scale;
  const Gains gains{p, s.d_gain + added_d, s.i_gain + p * joint.integral_rate};
  double slope = 1.0;
  const double raw = controller(joint, gains, in, profiled(joint, in, inner), limit, inner);
  out.duty = shaped(joint, raw, 1.0, limit, in.h, inner, slope);

  out.current = (out.duty * out.volt - back_emf * in.motor_velocity) / resistance;
  const double stall = torque_constant * out.volt / resistance;
  out.stiffness = stall * slope * gains.p;
  out.damping = stall * slope * gains.d;
  out.back_emf_damping = torque_constant * back_emf / resistance;
  const double current_limit = std::min(limit_or_none(s.current_limit), joint.current_limit);
  const double torque_limit = limit_or_none(s.torque_limit);
  if (std::abs(out.current) > current_limit) {
    out.current = std::copysign(current_limit, out.current);
    out.stiffness = out.damping = out.back_emf_damping = 0.0;
  }
  out.torque = torque_constant * out.current;
  if (std::abs(out.torque) > torque_limit) {
    out.torque = std::copysign(torque_limit, out.torque);
    out.stiffness = out.damping = out.back_emf_damping = 0.0;
  }
  return out;
}

/// Torque sources: follow a torque, or a goal position with kp and kd. No motor model, so limits
/// are plain torques.
ServoOutput torque_source(const JointParams& joint, const ServoInput& in, InnerState& inner) {
  const JointSettings& s = joint.nominal;
  const bool position = s.actuator == Actuator::position_pd;
  ServoOutput out;
  out.volt = s.voltage * in.supply;
  const double full = limit_or_none(s.torque_limit);
  double limit = full * joint.output_limit;
  double slope = 1.0, raw = in.command.value;
  Gains gains{0, 0, 0};
  if (position) {
    const double p = s.kp * joint.p_scale;
    gains = {p, s.kd + joint.d_torque, p * joint.integral_rate};
    raw = controller(joint, gains, in, profiled(joint, in, inner), limit, inner);
  }
  const double warm = std::max(0.0, 1.0 - joint.derating * in.warming);
  double gain = joint.torque_scale * warm;
  if (position) gain = gain * in.supply / joint.resistance_scale;
  out.torque = gain * shaped(joint, raw, full, kNone, in.h, inner, slope);
  out.stiffness = gain * slope * gains.p;
  out.damping = gain * slope * gains.d;
  // torque-speed line: what is left of the limit in the direction of motion
  double upper = limit, lower = limit;
  if (joint.no_load_speed != kNone && limit < kNone) {
    upper = limit * std::max(0.0, 1.0 - in.motor_velocity / joint.no_load_speed);
    lower = limit * std::max(0.0, 1.0 + in.motor_velocity / joint.no_load_speed);
  }
  if (out.torque > upper || out.torque < -lower) {
    out.torque = std::clamp(out.torque, -lower, upper);
    out.stiffness = out.damping = 0.0;
  }
  out.duty = full < kNone ? out.torque / full : 0.0;
  return out;
}

/// Integral gain over proportional gain, 1/s; 0: none.
double integral_rate(const JointParams& joint) {
  const JointSettings& s = joint.nominal;
  const bool servo = s.actuator == Actuator::dc_servo;
  if (!servo && s.actuator != Actuator::position_pd) return 0.0;
  const double own = servo && s.p_gain > 0.0 ? s.i_gain / (s.p_gain * joint.p_scale) : 0.0;
  return own + joint.integral_rate;
}

}  // namespace

void settle_integral(const JointParams& joint, double torque, double supply, InnerState& inner) {
  constexpr double kHeld = 3.0;  // s
  const double rate = integral_rate(joint);
  if (!(rate > 0.0)) return;
  const JointSettings& s = joint.nominal;
  const bool servo = s.actuator == Actuator::dc_servo;
  // d torque / d (P gain times angle)
  const double strength = servo ? s.torque_constant * joint.torque_scale * s.voltage * supply /
                                      (s.resistance * joint.resistance_scale)
                                : joint.torque_scale * supply / joint.resistance_scale;
  const double p = (servo ? s.p_gain : s.kp) * joint.p_scale;
  if (!(strength * p > 0.0)) return;
  const double full = servo ? std::min(s.duty_limit, joint.output_limit) : kNone;
  // rad of error that would hold it
  const double held = std::clamp(torque / strength, -full, full) / p;
  // under P and I a standing error decays with the rate of the integral
  inner.integral = held * (1.0 - std::exp(-rate * kHeld)) / rate;
}

ServoOutput servo_step(const JointParams& joint, const ServoInput& input, InnerState& inner) {
  if (input.command.off || joint.nominal.actuator == Actuator::passive) {
    inner.integral = inner.filtered = 0.0;
    inner.profile_set = false;
    ServoOutput out;
    out.volt = joint.nominal.voltage * input.supply - input.supply_drop;
    return out;
  }
  return joint.nominal.actuator == Actuator::dc_servo ? dc_servo(joint, input, inner)
                                                      : torque_source(joint, input, inner);
}

double ripple_at(const Ripple& r, double x) {
  return r.zero() ? 0.0 : r.sine * std::sin(r.order * x) + r.cosine * std::cos(r.order * x);
}
double ripple_slope(const Ripple& r, double x) {
  return r.zero() ? 0.0
                  : r.order * (r.sine * std::cos(r.order * x) - r.cosine * std::sin(r.order * x));
}

double encoder_reading(const JointParams& joint, double x) {
  return (1.0 + joint.encoder_scale) * x + ripple_at(joint.encoder_error, x) -
         ripple_at(joint.gear_error, x) + joint.encoder_offset;
}

double encoder_slope(const JointParams& joint, double x) {
  return 1.0 + joint.encoder_scale + ripple_slope(joint.encoder_error, x) -
         ripple_slope(joint.gear_error, x);
}

double position_for_reading(const JointParams& joint, double reading) {
  double x = (reading - joint.encoder_offset) / (1.0 + joint.encoder_scale);
  if (joint.encoder_error.zero() && joint.gear_error.zero()) return x;
  for (int k = 0; k < 8; ++k)
    // contracts: slopes are small
    x -= (encoder_reading(joint, x) - reading) / (1.0 + joint.encoder_scale);
  return x;
}

}  // namespace sanso::diagnose
