// What to tell the servos so that the robot follows a reference that its softness would blur: the
// planner runs the motion on the model of this very robot, with knots of 20 ms and without noise or
// delay, and the targets that it sends are written down. Sag, the rotors' inertia, the motors'
// speed line and the controller's own limits are in them then.
#pragma once

#include <string>
#include <vector>

#include "host/motion/make/flight_jog.h"
#include "host/motion/motion.h"
#include "host/mpc/cost.h"
#include "shared/model/step_model.h"

namespace sanso::motion {

/// How closely the planner follows, and what the controller lets through.
struct RehearsalSettings {
  double base_z = 1393.0, base_rise = 8.8, joints = 3.2, joint_rates = 0.1, input = 0.074;
  double input_limit_rad = 0.8;
  double target_rate_rad_s = 60.0;  // of the controller's guard, as the motion asks for
  double target_offset_rad = 0.6;   // of the guard
  double torque_limit_Nm = 3.7;     // 0.9 of the stall torque: the guard keeps the rest
};

/// How a motion came out in the model.
struct Rehearsal {
  Trajectory told;                // the model's base, and the targets in place of its joints
  std::vector<double> flights_s;  // both soles under 1 N, between second lift and last landing
  double double_support_share = 1.0;
  double largest_tilt_rad = 0.0;
  double place_error_m = 0.0;  // at the end
  bool upright = false;        // to the end

  /// Flights of at least so long, per step that could have one.
  double flight_share(double at_least_s) const;
  double steps = 1.0;
};

/// Runs the reference once, every 10 ms one plan; deterministic. A robot that falls ends it: then
/// `upright` is false and `told` ends there.
Rehearsal rehearse(const FlightReference& reference, const model::StepModel& model,
                   const RehearsalSettings& settings = {});

/// The motion's file: primitives that say what was told, the model's base as the cost's reference,
/// and all of a jog's clauses. Its joints are targets, which no joint reaches, and cost little.
/// Throws MotionError when the rehearsal fell.
Motion jog_motion(const std::string& name, const FlightJog& figures,
                  const FlightReference& reference, const Rehearsal& rehearsal,
                  const RehearsalSettings& settings = {});

/// More is better: long flights at every step, little double support, upright and in its place.
double worth(const Rehearsal& rehearsal);

}  // namespace sanso::motion
