// Plain data of a simulation step for one double or for several shots in step (lanes): states,
// what goes into servo and transmission, what comes out.
#pragma once

namespace sanso::diagnose {

/// Yes or no by lane; in lanes 1 or 0.
template <class T>
struct FlagType {
  using type = T;
};
template <>
struct FlagType<double> {
  using type = bool;
};
template <class T>
using FlagOf = typename FlagType<T>::type;

/// Inner states of a joint besides position and velocity. All zero at rest.
template <class T>
struct InnerStateOf {
  T motor_offset = 0.0;                  // rad, motor minus link (play, compliance)
  T motor_speed_offset = 0.0;            // rad/s
  T bristle = 0.0;                       // rad, presliding
  T slip[4] = {0.0, 0.0, 0.0, 0.0};      // rad, Maxwell elements
  T integral = 0.0;                      // rad s
  T filtered = 0.0;                      // controller output after its filter
  T profile = 0.0, profile_speed = 0.0;  // rad, rad/s
  FlagOf<T> profile_set = FlagOf<T>(0.0);
  T rest_time = 0.0;         // s since the joint last moved
  T heat = 0.0;              // K above the start, when no temperature was recorded
  T velocity_channel = 0.0;  // rad/s after the velocity filter
};

template <class T>
struct CommandOf {
  T value;        // mean over the interval; meaningless when off
  T rate;         // per second, of the sample interval
  FlagOf<T> off;  // empty cell: the actuator is switched off
};

/// Gains of a position loop, in the unit of its output (duty, N m).
template <class T>
struct GainsOf {
  T p = 0.0, d = 0.0, i = 0.0, goal = 0.0;  // per rad, per rad/s, per rad s, per rad/s of the goal
};

/// What the servo sees at one instant.
template <class T>
struct ServoInputOf {
  CommandOf<T> command;
  T h;               // s, step
  T position;        // rad, as the encoder shows it
  T velocity;        // rad/s, on the encoder's side
  T motor_velocity;  // rad/s, of the motor (back-EMF)
  T supply;          // V over nominal V, before its drop
  T supply_drop;     // V
  T warming;         // K above the start
  GainsOf<T> gains;  // servo_gains(); all with an integral, or none
};

template <class T>
struct ServoOutputOf {
  T torque = 0.0;            // N m at the output shaft
  T current = 0.0;           // A
  T duty = 0.0;              // -1..1
  T volt = 0.0;              // V at the driver
  T stiffness = 0.0;         // -d torque / d position, N m/rad
  T damping = 0.0;           // -d torque / d velocity of the encoder's side
  T back_emf_damping = 0.0;  // -d torque / d motor_velocity
};

/// What the joint looks like at the middle of the step before its outcome is known.
template <class T>
struct JointInstantOf {
  T h;         // s
  T q_half;    // rad, q + h/2 dq
  T dq;        // rad/s at the start
  T inertia;   // kg m^2, M_jj of the tree
  T external;  // N m, minus the bias: what gravity and motion of the others ask of the joint
  T warming;   // K above the start
};

/// The joint's part of (M + diag(added)) Ddq = impulse - h bias + coupling friction, and the
/// coordinate friction acts on: y' = y0 + mobility f + coupling dq', with |f| limited by friction.
/// Rigid joints: y' = dq'.
template <class T>
struct JointPartOf {
  T added = 0.0;    // kg m^2, to the diagonal
  T impulse = 0.0;  // N m s
  T y0 = 0.0, mobility = 0.0, coupling = 1.0;
  T f_min = 0.0, f_max = 0.0;  // N m s, impulses friction can give
  T slack = 0.0;               // 1/(kg m^2): inside them friction lets y' = -slack f through
  bool two_mass = false;
  bool rubs = false;    // f_min and f_max may differ from 0
  bool creeps = false;  // slack may differ from 0
  // N m: springs, cogging, stops, drag (for reports)
  T passive_torque = 0.0;
  T bristle_gain = 0.0, bristle_denominator = 1.0;  // to advance the bristle
};

}  // namespace sanso::diagnose
