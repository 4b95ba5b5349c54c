// One joint of a hidden world, from goal to joint torque: an integer-PWM servo at 1 kHz, a DC
// motor, dry friction, a gear that may have play or give. Own formulas, two or more of each, so
// that no case is explained by knowing them, small explicit steps:
// nothing here is the diagnosis's simulator.
#pragma once

#include <cstdint>

namespace sanso::conceal {

inline constexpr double kPwmSteps = 885;  // integer duty

/// Dry friction from rest to sliding: bristles (LuGre), a smooth hysteresis (Dahl, exponent 2), or
/// none at rest.
enum class FrictionLaw { lugre, dahl, arctangent };
/// How breakaway falls to sliding with speed.
enum class Fall { gaussian, lorentzian };
/// Teeth that meet across the play: springs, or round bodies that lose energy in their impact
/// (Hunt, Crossley).
enum class Teeth { linear, hertzian };
/// When a servo takes a command that waits: at once, or when it looks, every few milliseconds.
enum class Mailbox { at_once, polled };

/// Which formulas a world follows.
struct Formulas {
  FrictionLaw friction = FrictionLaw::lugre;
  Fall fall = Fall::gaussian;
  Teeth teeth = Teeth::linear;
  Mailbox mailbox = Mailbox::at_once;
};

/// Everything that may be hidden. The defaults are a joint without any effect.
struct JointTruth {
  Formulas formulas;
  // servo and motor; figures of the XM430-W350 at 12 V
  // duty/rad; duty s/rad; 1/s; s, relative to P
  double p_gain = 3.223, d_gain = 0;
  // registers of their own: nothing that changes the P gain changes them
  double i_gain = 0, feed_forward = 0;  // duty per rad s, per rad/s of the goal
  double duty_limit = 1, voltage = 12, resistance = 5.22, torque_constant = 1.78, back_emf = 2.49;
  double current_limit = 1e9, output_filter_s = 0, dead_zone = 0, profile_speed = 1e9,
         profile_acceleration = 1e9;
  double armature = 0.03;
  // friction
  double viscous = 0.05, coulomb = 0.05, stribeck = 0, stribeck_speed = 0.2;
  double load = 0, drive = 0, backdrive = 0, quadratic = 0, coulomb_difference = 0,
         viscous_difference = 0;
  double ripple_sine = 0, ripple_cosine = 0, ripple_order = 1;
  double static_friction = 0, dwell_rate = 0;
  double bristle_stiffness = 4000, bristle_damping = 0.4;  // N m/rad, N m s/rad
  // gear
  double backlash = 0, compliance = 0, compliance_damping = 0.3, efficiency = 1;
  double cogging_sine = 0, cogging_cosine = 0, cogging_order = 1;
  double spring = 0, spring_torque = 0, air_drag = 0;
  double stop_stiffness = 0, stop_position = 1e9, stop_side = 1;
  // clock
  double command_delay_s = 0.002, sensor_delay_s = 0.001, jitter_s = 0, loss = 0;
  int hold_cycles = 1;
  // sensor
  double offset = 0, encoder_sine = 0, encoder_cosine = 0, encoder_scale = 0, velocity_filter_s = 0;
  double record_offset = 0;  // of the recording alone: the servo does not read it
  double quantum = 0.00153398078788564;
  // physics that the diagnosis's library has no name for
  double cubic_spring = 0;   // N m/rad^3
  double angle_damping = 0;  // N m s/rad, times sin^2 of the angle
  // duty lost at a large error: P e (1 - softening e^2)
  double gain_softening = 0;
  double creep_spring = 0, creep_time_s = 0.5;  // spring whose rest angle follows the joint slowly
};

/// The moving parts of a joint besides position and velocity.
struct JointMemory {
  double motor_angle = 0, motor_rate = 0;  // used when the gear has play or gives
  double bristle = 0, integral = 0, filtered = 0, profile = 0, profile_rate = 0, last_goal = 0;
  double goal_rate = 0, rest_s = 0, creep_angle = 0, gear_torque = 0;
  double duty = 0, current = 0, motor_torque = 0;
  bool started = false;
};

bool two_masses(const JointTruth& joint);

/// What the encoder shows for a link angle, before its steps.
double encoder_angle(const JointTruth& joint, double link_angle);
/// What is recorded for that angle.
double recorded_angle(const JointTruth& joint, double link_angle);

/// Instant of the command that a servo acts on at time t, s. On average `command_delay_s` before t,
/// whatever the mailbox.
double instant_of_command(const JointTruth& joint, double t);

/// The servo's own loop, once a period: duty from the goal. `on` false: bridge open.
void run_servo(const JointTruth& joint, double goal, bool on, double link_angle, double period_s,
               JointMemory& memory);

/// One step of `h`: torque on the link [N m]. `external` is what gravity and the other links put on
/// the joint.
double run_gear(const JointTruth& joint, double supply_V, bool on, double link_angle,
                double link_rate, double external, double h, JointMemory& memory);

}  // namespace sanso::conceal
