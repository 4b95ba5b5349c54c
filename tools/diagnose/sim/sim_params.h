// Every figure the simulator works with: the model folder's, and one field for everything an effect
// of the library can change. The initial value of such a field is the effect's null: with it the
// simulation is bit for bit the nominal one.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/settings_of_simulation.h"

namespace sanso::diagnose {

inline constexpr double kNone = std::numeric_limits<double>::infinity();

/// a sin(order x) + b cos(order x)
struct Ripple {
  double sine = 0.0, cosine = 0.0, order = 1.0;
  bool zero() const { return sine == 0.0 && cosine == 0.0; }
  bool operator==(const Ripple&) const = default;
};

/// One joint. For prismatic joints read m for rad, N for N m, kg for kg m^2. Grouped by port, in
/// the order of the signal.
struct JointParams {
  JointSettings nominal;  // as the model folder says (after the sidecar)

  // clock and command path
  double command_delay = 0.0;  // s, added to nominal.command_delay_s
  double sensor_delay = 0.0;   // s, added to nominal.sensor_delay_s
  int hold_cycles = 1;         // the servo takes every n-th command
  // s, drawn anew for every command: it is taken up to so much early or late
  double command_scatter = 0.0;
  double loss = 0.0;    // probability that a command is lost and the one before stays
  double jitter = 0.0;  // s, standard deviation of the instant of a reading
  // firmware
  double p_scale = 1.0;  // on p_gain / kp
  // N m s/rad of additional damping by the servo (at nominal voltage)
  double d_torque = 0.0;
  double d_on_error = 0.0;     // 1: it damps the error, 0: the joint's own velocity
  double output_filter = 0.0;  // s, first order, on the controller's output
  bool filters_rate = false;   // on what the D gain damps alone
  // P gain (p_gain / kp) of model.toml, to which integral_rate and feed_forward refer: registers of
  // their own, which a recording with another P gain leaves alone. 0: nominal's
  double stated_gain = 0.0;
  // V of model.toml, at which d_torque is what it says: a gain of the firmware's duty, weaker where
  // a recording's supply is. 0: nominal's
  double stated_voltage = 0.0;
  double integral_rate = 0.0;  // 1/s: integral gain over proportional gain
  // of the output's limit: to here the integral goes on while the output is limited
  double windup = 0.0;
  double feed_forward = 0.0;            // s: gain on the goal's velocity over proportional gain
  double profile_speed = kNone;         // rad/s
  double profile_acceleration = kNone;  // rad/s^2
  double dead_zone = 0.0;               // of full output
  // electrical
  double output_limit = 1.0;  // of full duty (torque where there is no duty)
  // rad/s; torque falls to zero there (actuators without a motor model)
  double no_load_speed = kNone;
  double current_limit = kNone;  // A (dc_servo)
  double torque_scale = 1.0;     // torque constant (and back-EMF) over nominal
  double resistance_scale = 1.0;
  double derating = 0.0;  // 1/K: torque lost by degree of motor temperature
  // transmission: friction
  // N m s/rad, added to nominal.viscous
  double viscous = 0.0;
  // N m, added to nominal.coulomb
  double coulomb = 0.0;
  double stribeck = 0.0, stribeck_speed = 0.2, stribeck_shape = 1.0;  // N m, rad/s, exponent
  // N m per N m of |motor - external| torque
  double load_friction = 0.0;
  // K_m, K_e of |K_m tau_m - K_e tau_e|
  double drive_friction = 0.0, backdrive_friction = 0.0;
  double quadratic_load_friction = 0.0;  // 1/(N m)
  // forwards minus mean, N m and N m s/rad
  double coulomb_difference = 0.0, viscous_difference = 0.0;
  double presliding_compliance = 0.0, presliding_damping = 0.0;  // rad/(N m), N m s/rad
  double creep_speed = 0.0;  // rad/s at which dry friction is all there
  // Maxwell elements: N m, N m/rad, exponent
  double slip_torque = 0.0, slip_stiffness = 0.0, slip_spread = 1.0;
  Ripple friction_ripple;  // N m over q
  // 1/K, friction * exp(-beta (T - T0))
  double friction_temperature = 0.0;
  // N m, per ln(1 + rest time in s)
  double static_friction = 0.0, dwell_rate = 0.0;
  // rad/s at which these are lost
  double static_speed = 0.2;
  double efficiency = 1.0;
  // transmission: geometry and springs
  double backlash = 0.0;                              // rad, whole width
  double compliance = 0.0, compliance_damping = 0.0;  // rad/(N m), N m s/rad
  // which side of play and spring the servo measures
  bool encoder_at_motor = false;
  Ripple gear_error;                         // rad over q
  Ripple cogging;                            // N m over q
  double armature = 0.0;                     // kg m^2, added to nominal.armature
  double spring = 0.0, spring_torque = 0.0;  // N m/rad, N m: -k q + tau0
  double air_drag = 0.0;                     // N m s^2/rad^2
  // N m/rad beyond it; side +1 above, -1 below
  double stop_stiffness = 0.0, stop_position = kNone, stop_side = 1.0;
  // its damping over sqrt(stiffness inertia): what of an impact it swallows
  double stop_loss = 0.0;
  // sensor: what the servo and the recording read
  double encoder_offset = 0.0;  // rad
  Ripple encoder_error;         // rad over q
  double encoder_scale = 0.0;   // relative
  // rad, of the recording alone: its zero is not the servo's
  double record_offset = 0.0;
  double velocity_filter = 0.0;  // s, first order, on the dq channel only

  bool operator==(const JointParams&) const = default;
};

/// A constant force on a link, base axes, N, between two instants of the recording.
struct WorldForce {
  int joint = 0;
  Vec3 force{0, 0, 0};
  double from_s = -kNone, until_s = kNone;
  bool operator==(const WorldForce&) const = default;
};

/// A body that is on a link from an instant on.
struct LatePayload {
  int joint = 0;
  BodyInertia body;
  double from_s = 0.0;
  bool operator==(const LatePayload&) const = default;
};

struct SimParams {
  RobotTree tree;
  Vec3 gravity{0, 0, -9.81};
  double period_s = 0.01;
  std::vector<JointParams> joints;
  // the supply that all joints share
  double supply_level = 0.0;       // relative to nominal.voltage
  double supply_slope = 0.0;       // relative, per minute
  double supply_resistance = 0.0;  // ohm, carries the sum of |i duty|
  std::vector<WorldForce> forces;
  std::vector<LatePayload> late_payloads;
  SimulationSettings settings;
  std::size_t size() const { return tree.size(); }
};

/// The nominal model with its payloads. Its [[effect]] entries are not applied here
/// (effects/from_model.h does that).
SimParams make_params(const ModelFolder& model, const SimulationSettings& settings = {});

}  // namespace sanso::diagnose
