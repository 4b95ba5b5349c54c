// Firmware and electrical ports of one joint: from goal and measured position to motor torque at
// the output shaft.
#pragma once

#include "tools/diagnose/sim/command_path.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

/// Inner states of a joint besides position and velocity. All zero at rest.
struct InnerState {
  double motor_offset = 0.0;                  // rad, motor minus link (play, compliance)
  double motor_speed_offset = 0.0;            // rad/s
  double bristle = 0.0;                       // rad, presliding
  double slip[4] = {0, 0, 0, 0};              // rad, Maxwell elements
  double integral = 0.0;                      // rad s
  double filtered = 0.0;                      // controller output after its filter
  double profile = 0.0, profile_speed = 0.0;  // rad, rad/s
  bool profile_set = false;
  double rest_time = 0.0;         // s since the joint last moved
  double heat = 0.0;              // K above the start, when no temperature was recorded
  double velocity_channel = 0.0;  // rad/s after the velocity filter
  bool velocity_set = false;
};

/// What the servo sees at one instant.
struct ServoInput {
  CommandPath::Command command;
  double h;               // s, step
  double position;        // rad, as the encoder shows it
  double velocity;        // rad/s, on the encoder's side
  double motor_velocity;  // rad/s, of the motor (back-EMF)
  double supply;          // V over nominal V, before its drop
  double supply_drop;     // V
  double warming;         // K above the start
};

struct ServoOutput {
  double torque = 0.0;            // N m at the output shaft
  double current = 0.0;           // A
  double duty = 0.0;              // -1..1
  double volt = 0.0;              // V at the driver
  double stiffness = 0.0;         // -d torque / d position, N m/rad
  double damping = 0.0;           // -d torque / d velocity of the encoder's side
  double back_emf_damping = 0.0;  // -d torque / d motor_velocity
};

/// One step of the servo; advances its inner states by input.h. Switched off: no torque, no
/// back-EMF.
ServoOutput servo_step(const JointParams& joint, const ServoInput& input, InnerState& inner);

/// The integral of a servo that has held `torque` for a while, as before a recording begins: a few
/// seconds, so that a slow integral carries only a part of it. `supply` over nominal.
void settle_integral(const JointParams& joint, double torque, double supply, InnerState& inner);

/// Encoder reading for a position of the side it sits on, and the position for a reading.
double encoder_reading(const JointParams& joint, double position);
double position_for_reading(const JointParams& joint, double reading);
/// d reading / d position.
double encoder_slope(const JointParams& joint, double position);
double ripple_at(const Ripple& ripple, double x);
double ripple_slope(const Ripple& ripple, double x);

}  // namespace sanso::diagnose
