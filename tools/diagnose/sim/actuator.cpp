// The servo of one robot, the integral it begins with, and readings back to positions.
#include "tools/diagnose/sim/actuator.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/sim/servo.h"

namespace sanso::diagnose {
namespace {

/// P gain that the ratios of a joint refer to.
double stated_gain(const JointParams& joint) {
  return joint.stated_gain > 0.0 ? joint.stated_gain : recording::loop_gain(joint.nominal);
}

/// Integral gain over proportional gain, both as they act, 1/s; 0: none.
double integral_rate(const JointParams& joint) {
  const JointSettings& s = joint.nominal;
  const double p = recording::loop_gain(s) * joint.p_scale;
  if (!(p > 0.0)) return 0.0;
  const double own = s.actuator == Actuator::dc_servo ? s.i_gain : 0.0;
  return (own + stated_gain(joint) * joint.integral_rate) / p;
}

}  // namespace

double settled_integral(const JointParams& joint, double torque, double supply, double held_s) {
  const double rate = integral_rate(joint);
  if (!(rate > 0.0)) return 0.0;
  const JointSettings& s = joint.nominal;
  const bool servo = s.actuator == Actuator::dc_servo;
  // d torque / d (P gain times angle)
  const double strength = servo ? s.torque_constant * joint.torque_scale * s.voltage * supply /
                                      (s.resistance * joint.resistance_scale)
                                : joint.torque_scale * supply / joint.resistance_scale;
  const double p = (servo ? s.p_gain : s.kp) * joint.p_scale;
  if (!(strength * p > 0.0)) return 0.0;
  const double full = servo ? std::min(s.duty_limit, joint.output_limit) : kNone;
  // rad of error that would hold it
  const double held = std::clamp(torque / strength, -full, full) / p;
  // under P and I a standing error decays with the rate of the integral
  return held * (1.0 - std::exp(-rate * held_s)) / rate;
}

GainsOf<double> servo_gains(const JointParams& joint) {
  const JointSettings& s = joint.nominal;
  const double stated = stated_gain(joint);
  if (s.actuator == Actuator::dc_servo) {
    const double voltage = joint.stated_voltage > 0.0 ? joint.stated_voltage : s.voltage;
    const double stall = s.torque_constant * voltage / s.resistance;  // N m per duty, nominal
    const double d = joint.d_torque != 0.0 && stall > 0.0 ? joint.d_torque / stall : 0.0;
    return {s.p_gain * joint.p_scale, s.d_gain + d, s.i_gain + stated * joint.integral_rate,
            stated * joint.feed_forward + d * joint.d_on_error};
  }
  if (s.actuator != Actuator::position_pd) return {};
  return {s.kp * joint.p_scale, s.kd + joint.d_torque, stated * joint.integral_rate,
          stated * joint.feed_forward + joint.d_torque * joint.d_on_error};
}

ServoOutput servo_step(const JointParams& joint, const ServoInput& input, InnerState& inner) {
  ServoInput own = input;
  own.gains = servo_gains(joint);
  return portable::servo_step(joint, own, inner);
}

double ripple_at(const Ripple& r, double x) { return portable::ripple_at(r, x); }
double ripple_slope(const Ripple& r, double x) { return portable::ripple_slope(r, x); }

double encoder_reading(const JointParams& joint, double x) {
  return portable::encoder_reading(joint, x);
}

double encoder_slope(const JointParams& joint, double x) {
  return 1.0 + joint.encoder_scale + ripple_slope(joint.encoder_error, x) -
         ripple_slope(joint.gear_error, x);
}

double position_for_reading(const JointParams& joint, double reading) {
  const double scale = 1.0 + joint.encoder_scale;
  double x = (reading - joint.encoder_offset - joint.record_offset) / scale;
  if (joint.encoder_error.zero() && joint.gear_error.zero()) return x;
  // contracts: slopes are small
  for (int k = 0; k < 8; ++k) x -= (encoder_reading(joint, x) - reading) / scale;
  return x;
}

}  // namespace sanso::diagnose
