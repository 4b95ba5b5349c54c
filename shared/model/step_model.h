// What the one-step model needs to know: parameters theta (masses, servos, friction) and their
// derived, constant form.
// Plain data without functions of its own, so that units compiled for different instruction sets
// may share it.
#pragma once

#include "shared/model/dimensions.h"
#include "shared/model/foot_shape.h"
#include "shared/model/op3_table.h"

namespace sanso::model {

/// One P-controlled servo at its output shaft.
struct ServoParameters {
  double stiffness;  // N m/rad, torque per position error
  // N m s/rad, back-EMF and viscous friction: the torque-speed line of the motor
  double damping;
  double armature;      // kg m^2, rotor inertia seen at the output
  double coulomb;       // N m, dry friction
  double torque_limit;  // N m, stall torque at full duty
  double zero = 0.0;    // rad, reads so much more than its joint's angle: a horn put on by hand
};

inline constexpr double kGravity_m_s2 = 9.81;  // downwards

/// theta: what identification may change. The links' lengths are fixed.
struct ModelParameters {
  BodyInertia body[kNumBodies];
  ServoParameters servo[kNumJoints];
  double friction_forward;   // along the foot's x axis (rolling direction of a skate), -
  double friction_sideways;  // across it, -
  // m, of the ground in the heights that the robot is told: camera, soles, what lies on the floor
  double ground_height = 0.0;
  // s, from a target to where it acts: bus, servo loop, filters of what it reads. A step is given
  // the targets that act in it; whoever asks for the step shifts them
  double target_lag_s = 0.0;
  FootShape foot = kSoles;
};

inline constexpr double kLongestTargetLag_s = 0.04;  // shorter than a model step

/// OP3 figures; XM430-W350 at 12 V with the position gain register at 560.
/// stiffness = 4.1 N m x 3.223 duty/rad, damping = 4.1 N m / 4.82 rad/s + 0.15 viscous.
ModelParameters nominal_parameters();
/// The same on skates: their mass, rolling friction 0.02 (small plastic wheels) and urethane's 0.6
/// across.
ModelParameters skating_parameters();

/// Contact solver: rounds of sweeps and a Newton step until every lane is solved; near a solution
/// Newton first. Bounded.
struct ContactSettings {
  int sweeps = 8;  // of a round: they find which rows touch, stick and slide
  // at most; nearly all states need one or two (kernel/contact_newton.h)
  int rounds = 12;
  // N s: solved when the impulses are that near to their own projection
  double tolerance = 1e-11;
  // softness relative to the diagonal: makes forces unique; a standing OP3 sinks 0.8 mm
  double regularization = 0.03;
  double recovery = 0.3;  // share of a penetration that one step removes
};

/// Derived constants of one set of parameters. Build with make_step_model, then never change it.
struct StepModel {
  struct Body {
    double mass;             // kg
    double first_moment[3];  // kg m, mass x com, link axes
    double inertia[6];       // kg m^2 about the link origin: xx xy xz yy yz zz
    double subtree_mass;     // kg, this body and all it carries
  };
  Body body[kNumBodies];
  ServoParameters servo[kNumJoints];
  double friction_forward;
  double friction_sideways;
  double ground_height;     // m
  double target_lag_s;      // s, 0 to kLongestTargetLag_s
  double gravity_world[3];  // m/s^2
  ContactSettings contact;
  FootShape foot;
};

/// The constants of these parameters, with first moments, inertias about the links' origins and
/// subtree masses worked out. Takes any theta; a mass that is not positive makes no sense.
StepModel make_step_model(const ModelParameters& theta);

}  // namespace sanso::model
