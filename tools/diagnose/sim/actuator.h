// Firmware and electrical ports of one joint: from goal and measured position to motor torque at
// the output shaft. The laws are those of servo.h, for one robot.
#pragma once

#include "tools/diagnose/sim/command_path.h"
#include "tools/diagnose/sim/lane_state.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

using InnerState = InnerStateOf<double>;
using ServoInput = ServoInputOf<double>;
using ServoOutput = ServoOutputOf<double>;

/// Gains of the joint's position loop as it acts, in duty (dc_servo) or torque (position_pd); all
/// 0: it has none.
GainsOf<double> servo_gains(const JointParams& joint);

/// One step of the servo, with its own gains; advances its inner states by input.h. Switched off:
/// no torque, no back-EMF.
ServoOutput servo_step(const JointParams& joint, const ServoInput& input, InnerState& inner);

/// The integral [rad s] of a servo that has held `torque` for `held_s`, as before a recording
/// begins; 0: it has none. `supply` over nominal.
double settled_integral(const JointParams& joint, double torque, double supply, double held_s);

/// Encoder reading for a position of the side it sits on, and the position for a reading.
double encoder_reading(const JointParams& joint, double position);
double position_for_reading(const JointParams& joint, double reading);
/// d reading / d position.
double encoder_slope(const JointParams& joint, double position);
/// sine sin(order x) + cosine cos(order x), and its derivative by x; x in rad, unit of the ripple.
double ripple_at(const Ripple& ripple, double x);
double ripple_slope(const Ripple& ripple, double x);

}  // namespace sanso::diagnose
