// One function a kind of actuator. Each also gives the slope of the torque by the motor's speed,
// for the implicit step.
#pragma once

#include "tools/diagnose/sim/lane_math.h"
#include "tools/diagnose/sim/lane_state.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose::SANSO_ISA {

inline bool is_none(const Ripple& r) { return r.sine == 0.0 && r.cosine == 0.0; }
/// A setting of 0 is no limit.
inline double limit_or_none(double setting) { return setting > 0.0 ? setting : kNone; }
inline bool is_set(bool flag) { return flag; }
template <int W>
inline MaskOf<Pack<W>> is_set(Pack<W> flag) {
  return less(Pack<W>(0.5), flag);
}

template <class T>
inline T ripple_at(const Ripple& r, T x) {
  if (is_none(r)) return 0.0;
  T sine, cosine;
  kernel::sincos(r.order * x, sine, cosine);
  return r.sine * sine + r.cosine * cosine;
}
template <class T>
inline T ripple_slope(const Ripple& r, T x) {
  if (is_none(r)) return 0.0;
  T sine, cosine;
  kernel::sincos(r.order * x, sine, cosine);
  return r.order * (r.sine * cosine - r.cosine * sine);
}

/// What the servo's loop reads for a position of the side its encoder sits on.
template <class T>
inline T servo_reading(const JointParams& joint, T x) {
  return (1.0 + joint.encoder_scale) * x + ripple_at(joint.encoder_error, x) -
         ripple_at(joint.gear_error, x) + joint.encoder_offset;
}
/// What the recording holds for that position.
template <class T>
inline T encoder_reading(const JointParams& joint, T x) {
  return servo_reading(joint, x) + joint.record_offset;
}

/// Velocity and acceleration limits of the goal, as a servo with an internal profile follows it.
template <class T>
inline CommandOf<T> profiled(const JointParams& joint, const ServoInputOf<T>& in,
                             InnerStateOf<T>& inner) {
  CommandOf<T> command = in.command;
  if (joint.profile_speed == kNone && joint.profile_acceleration == kNone) return command;
  const MaskOf<T> known = is_set(inner.profile_set);
  inner.profile = choose(known, inner.profile, in.position);
  inner.profile_speed = choose(known, inner.profile_speed, T(0.0));
  inner.profile_set = FlagOf<T>(1.0);
  const T ahead = command.value - inner.profile;
  T speed = min_of(abs_of(ahead) / in.h, T(joint.profile_speed));
  if (joint.profile_acceleration != kNone) {
    // able to stop at the goal
    speed = min_of(speed, sqrt_of(2.0 * joint.profile_acceleration * abs_of(ahead)));
    const T change = joint.profile_acceleration * in.h;
    inner.profile_speed += clamped(with_sign(speed, ahead) - inner.profile_speed, -change, change);
  } else {
    inner.profile_speed = with_sign(speed, ahead);
  }
  inner.profile += in.h * inner.profile_speed;
  command.value = inner.profile;
  command.rate = inner.profile_speed;
  return command;
}

/// Dead zone, first-order filter and limit of a controller's output; `slope` becomes d output / d
/// raw.
template <class T>
inline T shaped(const JointParams& joint, T raw, double full, double limit, T h,
                InnerStateOf<T>& inner, T& slope) {
  slope = 1.0;
  if (joint.dead_zone > 0.0 && full < kNone) {
    const T zone = joint.dead_zone * full;
    const MaskOf<T> beyond = less(zone, abs_of(raw));
    slope = choose(beyond, T(1.0), T(0.0));
    raw = choose(beyond, raw - with_sign(zone, raw), T(0.0));
  }
  if (joint.output_filter > 0.0 && !joint.filters_rate) {
    const T gain = h / (joint.output_filter + h);
    inner.filtered += gain * (raw - inner.filtered);
    raw = inner.filtered;
    slope = slope * gain;
  }
  if (limit == kNone) return raw;
  const MaskOf<T> limited = less(T(limit), abs_of(raw));
  slope = choose(limited, T(0.0), slope);
  return choose(limited, with_sign(T(limit), raw), raw);
}

/// What of a change of speed a step of h [s] lets through to the D gain.
template <class T>
inline T rate_share(const JointParams& joint, T h) {
  return joint.filters_rate ? h / (joint.output_filter + h) : T(1.0);
}

/// Controller common to dc_servo (gains in duty) and position_pd (gains in torque). Output before
/// its limit, in the unit of the gains; moves the integral, which stops at `limit`.
template <class T>
inline T controller(const JointParams& joint, const ServoInputOf<T>& in, const CommandOf<T>& goal,
                    double limit, InnerStateOf<T>& inner) {
  const GainsOf<T>& gains = in.gains;
  const T error = goal.value - in.position;
  T without_integral = gains.p * error;
  const T damping = -gains.d * in.velocity;
  if (joint.filters_rate && joint.output_filter > 0.0) {
    inner.filtered +=
        rate_share<T>(joint, in.h) * (damping + gains.goal * goal.rate - inner.filtered);
    without_integral += inner.filtered;
  } else {
    without_integral = without_integral + damping + gains.goal * goal.rate;
  }
  if (!any(less(T(0.0), gains.i))) return without_integral;
  const T integral = inner.integral + in.h * error;
  // at the limit the integral may only move back, or go on as far as the firmware lets it wind up
  const MaskOf<T> inside = less(abs_of(without_integral + gains.i * integral), T(limit));
  const MaskOf<T> back = less(error * inner.integral, T(0.0));
  const MaskOf<T> winds_up = less(gains.i * abs_of(integral), T(joint.windup * limit));
  inner.integral = choose(either(inside, either(back, winds_up)), integral, inner.integral);
  return without_integral + gains.i * inner.integral;
}

/// Beyond what a limit lets through, nothing follows position or speed.
template <class T>
inline void stiff_unless(MaskOf<T> limited, ServoOutputOf<T>& out) {
  out.stiffness = choose(limited, T(0.0), out.stiffness);
  out.damping = choose(limited, T(0.0), out.damping);
  out.back_emf_damping = choose(limited, T(0.0), out.back_emf_damping);
}

/// What a winding that is `warming` [K] warmer leaves of its torque constant; at least 0.
template <class T>
inline T warm_share(const JointParams& joint, T warming) {
  return joint.derating == 0.0 ? T(1.0) : max_of(T(0.0), 1.0 - joint.derating * warming);
}

template <class T>
inline ServoOutputOf<T> dc_servo(const JointParams& joint, const ServoInputOf<T>& in,
                                 InnerStateOf<T>& inner) {
  const JointSettings& s = joint.nominal;
  ServoOutputOf<T> out;
  out.volt = s.voltage * in.supply - in.supply_drop;
  const T torque_constant = s.torque_constant * joint.torque_scale * warm_share(joint, in.warming);
  const double back_emf = s.back_emf * joint.torque_scale;
  const double resistance = s.resistance * joint.resistance_scale;

  const double limit = s.duty_limit < joint.output_limit ? s.duty_limit : joint.output_limit;
  T slope = 1.0;
  const T raw = controller(joint, in, profiled(joint, in, inner), limit, inner);
  out.duty = shaped(joint, raw, 1.0, limit, in.h, inner, slope);

  out.current = (out.duty * out.volt - back_emf * in.motor_velocity) / resistance;
  const T stall = torque_constant * out.volt / resistance;
  out.stiffness = stall * slope * in.gains.p;
  out.damping = stall * slope * in.gains.d * rate_share(joint, in.h);
  out.back_emf_damping = torque_constant * back_emf / resistance;
  const double own = limit_or_none(s.current_limit);
  const double most = own < joint.current_limit ? own : joint.current_limit;
  if (most != kNone) {
    const MaskOf<T> limited = less(T(most), abs_of(out.current));
    out.current = choose(limited, with_sign(T(most), out.current), out.current);
    stiff_unless(limited, out);
  }
  out.torque = torque_constant * out.current;
  const double torque_limit = limit_or_none(s.torque_limit);
  if (torque_limit != kNone) {
    const MaskOf<T> limited = less(T(torque_limit), abs_of(out.torque));
    out.torque = choose(limited, with_sign(T(torque_limit), out.torque), out.torque);
    stiff_unless(limited, out);
  }
  return out;
}

/// Torque sources: follow a torque, or a goal position with kp and kd. No motor model, so limits
/// are plain torques.
template <class T>
inline ServoOutputOf<T> torque_source(const JointParams& joint, const ServoInputOf<T>& in,
                                      InnerStateOf<T>& inner) {
  const JointSettings& s = joint.nominal;
  const bool position = s.actuator == Actuator::position_pd;
  ServoOutputOf<T> out;
  out.volt = s.voltage * in.supply;
  const double full = limit_or_none(s.torque_limit);
  const double limit = full * joint.output_limit;
  T slope = 1.0, raw = in.command.value;
  if (position) raw = controller(joint, in, profiled(joint, in, inner), limit, inner);
  T gain = joint.torque_scale * warm_share(joint, in.warming);
  if (position) gain = gain * in.supply / joint.resistance_scale;
  out.torque = gain * shaped(joint, raw, full, kNone, in.h, inner, slope);
  out.stiffness = gain * slope * in.gains.p;
  out.damping = gain * slope * in.gains.d * rate_share(joint, in.h);
  // torque-speed line: what is left of the limit in the direction of motion
  T upper = limit, lower = limit;
  if (joint.no_load_speed != kNone && limit < kNone) {
    upper = limit * max_of(T(0.0), 1.0 - in.motor_velocity / joint.no_load_speed);
    lower = limit * max_of(T(0.0), 1.0 + in.motor_velocity / joint.no_load_speed);
  }
  if (limit < kNone) {
    stiff_unless(either(less(upper, out.torque), less(out.torque, -lower)), out);
    out.torque = clamped(out.torque, -lower, upper);
  }
  if (full < kNone) out.duty = out.torque / full;
  return out;
}

/// One step of the servo; advances its inner states by input.h. Switched off: no torque, no
/// back-EMF.
template <class T>
inline ServoOutputOf<T> servo_step(const JointParams& joint, const ServoInputOf<T>& input,
                                   InnerStateOf<T>& inner) {
  const MaskOf<T> off = is_set(input.command.off);
  const bool passive = joint.nominal.actuator == Actuator::passive;
  ServoOutputOf<T> rests;
  if (passive || any(off)) rests.volt = joint.nominal.voltage * input.supply - input.supply_drop;
  if (passive || !any(negated(off))) {
    inner.integral = inner.filtered = 0.0;
    inner.profile_set = FlagOf<T>(0.0);
    return rests;
  }
  ServoOutputOf<T> out = joint.nominal.actuator == Actuator::dc_servo
                             ? dc_servo(joint, input, inner)
                             : torque_source(joint, input, inner);
  if (!any(off)) return out;
  const MaskOf<T> on = negated(off);
  out.torque = choose(on, out.torque, rests.torque);
  out.current = choose(on, out.current, rests.current);
  out.duty = choose(on, out.duty, rests.duty);
  out.volt = choose(on, out.volt, rests.volt);
  out.stiffness = choose(on, out.stiffness, rests.stiffness);
  out.damping = choose(on, out.damping, rests.damping);
  out.back_emf_damping = choose(on, out.back_emf_damping, rests.back_emf_damping);
  inner.integral = choose(on, inner.integral, T(0.0));
  inner.filtered = choose(on, inner.filtered, T(0.0));
  inner.profile_set = FlagOf<T>(choose(on, T(inner.profile_set), T(0.0)));
  return out;
}

}  // namespace sanso::diagnose::SANSO_ISA
