// The servo of one robot, the integral it begins with, and readings back to positions.
#include "tools/diagnose/sim/actuator.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/sim/servo.h"

namespace sanso::diagnose {
namespace {

/// Integral gain over proportional gain, both as they act, 1/s; 0: none.
double integral_rate(const JointParams& joint) {
  const JointSettings& s = joint.nominal;
  const double p = recording::loop_gain(s) * joint.p_scale;
  if (!(p > 0.0)) return 0.0;
  const double own = s.actuator == Actuator::dc_servo ? s.i_gain : 0.0;
  return (own + portable::stated_gain(joint) * joint.integral_rate) / p;
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

ServoOutput servo_step(const JointParams& joint, const ServoInput& input, InnerState& inner) {
  return portable::servo_step(joint, input, inner);
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
  double x = (reading - joint.encoder_offset) / (1.0 + joint.encoder_scale);
  if (joint.encoder_error.zero() && joint.gear_error.zero()) return x;
  for (int k = 0; k < 8; ++k)
    // contracts: slopes are small
    x -= (encoder_reading(joint, x) - reading) / (1.0 + joint.encoder_scale);
  return x;
}

}  // namespace sanso::diagnose
