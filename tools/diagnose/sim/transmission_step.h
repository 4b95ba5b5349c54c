// All forces of the transmission as constant plus slope times the velocity at the end of the
// step, so that stiff ones stay stable.
#pragma once

#include "tools/diagnose/sim/servo.h"

namespace sanso::diagnose::SANSO_ISA {

constexpr std::size_t kSlipElements = 4;

/// Play or compliance are on: the motor is a mass of its own.
inline bool has_two_masses(const JointParams& joint) {
  return joint.backlash > 0.0 || joint.compliance > 0.0;
}

template <class T>
inline T thermal_factor(const JointParams& joint, T warming) {
  if (joint.friction_temperature == 0.0) return 1.0;
  return exp_of(-joint.friction_temperature * warming);
}

/// Friction torque available at speed y under motor torque and external torque, N m, before the
/// sign of motion.
template <class T>
inline T friction_budget(const JointParams& joint, T motor, const JointInstantOf<T>& at, T y,
                         const InnerStateOf<T>& inner) {
  const T speed = abs_of(y);
  T budget = joint.nominal.coulomb + joint.coulomb;
  if (joint.stribeck != 0.0) {
    budget +=
        joint.stribeck * exp_of(-power_of(speed / joint.stribeck_speed, joint.stribeck_shape));
  }
  const T load = abs_of(motor - at.external);
  if (joint.load_friction != 0.0) budget += joint.load_friction * load;
  if (joint.drive_friction != 0.0 || joint.backdrive_friction != 0.0) {
    budget += abs_of(joint.drive_friction * motor - joint.backdrive_friction * at.external);
  }
  if (joint.quadratic_load_friction != 0.0) budget += joint.quadratic_load_friction * load * load;
  if (!is_none(joint.friction_ripple)) budget += ripple_at(joint.friction_ripple, at.q_half);
  if (joint.static_friction != 0.0 || joint.dwell_rate != 0.0) {
    const T at_rest = exp_of(-speed / joint.static_speed);
    const T grown = 1.0 + joint.dwell_rate * log1p_of(inner.rest_time);
    budget += at_rest * (joint.static_friction * grown +
                         (joint.nominal.coulomb + joint.coulomb) * (grown - 1.0));
  }
  budget = max_of(T(0.0), budget) * thermal_factor(joint, at.warming);
  if (joint.efficiency != 1.0) {
    // lost when driving: (1 - eta) tau; held back when driven: (1/eta - 1) tau
    const MaskOf<T> driving = no_more(T(0.0), motor * y);
    budget +=
        abs_of(motor) * choose(driving, T(1.0 - joint.efficiency), T(1.0 / joint.efficiency - 1.0));
  }
  return budget;
}

/// Share of the implicit end in a velocity-proportional force: 1/2 (midpoint) for slow decay,
/// towards 1 for fast decay, such that the scalar linear decay is integrated to third order.
template <class T>
inline T implicitness(T h_damping, T inertia) {
  const T z = h_damping / inertia;
  return choose(less(T(0.0), z), 0.5 + z / (12.0 + 2.0 * z), T(0.5));
}

/// Fully implicit damping of the presliding bristle and of the Maxwell elements that stick: force =
/// constant + slope y'.
template <class T>
struct Elastic {
  T constant = 0.0, slope = 0.0;  // N m, N m s/rad
};

/// Shares of the Maxwell elements in the torque: those of (i + 1)^spread.
struct SlipShares {
  double share[kSlipElements] = {};
};
inline SlipShares slip_shares(const JointParams& joint) {
  if (!(joint.slip_torque > 0.0)) return {};
  const double two = __builtin_pow(2.0, joint.slip_spread),
               three = __builtin_pow(3.0, joint.slip_spread);
  const double total = 1.0 + two + three + two * two;
  return {{1.0 / total, two / total, three / total, two * two / total}};
}

/// Torque [N m] of the slip elements as constant + slope y, for the speed y [rad/s] of a step h
/// [s]: elements that would slip give their limit.
template <class T>
inline Elastic<T> maxwell(const JointParams& joint, const SlipShares& shares, T h, T y,
                          const InnerStateOf<T>& inner) {
  Elastic<T> e;
  const double stiffness = joint.slip_stiffness / kSlipElements;
  for (std::size_t i = 0; i < kSlipElements; ++i) {
    const T limit = joint.slip_torque * shares.share[i];
    const T stretched = inner.slip[i] + h * y;
    const MaskOf<T> sticks = less(abs_of(stiffness * stretched), limit);
    e.constant += choose(sticks, stiffness * inner.slip[i], with_sign(limit, stretched));
    e.slope += choose(sticks, stiffness * h, T(0.0));
  }
  return e;
}

/// Stretches the elements by a step at speed y; those at their limit slip.
template <class T>
inline void advance_maxwell(const JointParams& joint, const SlipShares& shares, T h, T y,
                            InnerStateOf<T>& inner) {
  const double stiffness = joint.slip_stiffness / kSlipElements;
  for (std::size_t i = 0; i < kSlipElements; ++i) {
    const T limit = joint.slip_torque * shares.share[i] / stiffness;
    inner.slip[i] = clamped(inner.slip[i] + h * y, -limit, limit);
  }
}

/// Springs, stops, cogging and drag that act on the link itself.
template <class T>
inline void add_link_forces(const JointParams& joint, const JointInstantOf<T>& at,
                            JointPartOf<T>& part) {
  const bool stops = joint.stop_stiffness > 0.0;
  if (joint.spring == 0.0 && joint.spring_torque == 0.0 && is_none(joint.cogging) &&
      joint.air_drag == 0.0 && !stops)
    return;
  T force = 0.0, stiffness = 0.0, damping = 0.0;
  if (joint.spring != 0.0 || joint.spring_torque != 0.0) {
    force += joint.spring_torque - joint.spring * at.q_half;
    stiffness += T(joint.spring > 0.0 ? joint.spring : 0.0);
  }
  if (!is_none(joint.cogging)) force += ripple_at(joint.cogging, at.q_half);
  if (joint.air_drag != 0.0) {
    force -= joint.air_drag * abs_of(at.dq) * at.dq;
    damping += 2.0 * joint.air_drag * abs_of(at.dq);
  }
  if (stops) {
    const T into = at.q_half - joint.stop_position;
    const MaskOf<T> there = less(T(0.0), joint.stop_side * into);
    const T d = joint.stop_loss * sqrt_of(joint.stop_stiffness * at.inertia);
    force -= choose(there, joint.stop_stiffness * into + d * at.dq, T(0.0));
    stiffness += choose(there, T(joint.stop_stiffness), T(0.0));
    damping += choose(there, d, T(0.0));
  }
  part.passive_torque += force;
  part.impulse += at.h * force;
  part.added +=
      at.h * implicitness(at.h * damping, at.inertia) * damping + 0.25 * at.h * at.h * stiffness;
}

/// Spring and damper between motor and link over one step: torque k stretch + explicit_damping (w -
/// v) + implicit (Dw - Dv).
template <class T>
struct Coupling {
  T stretch = 0.0;                           // rad at mid-step, beyond the play; 0 inside it
  T k = 0.0;                                 // N m/rad; 0 inside the play
  T explicit_damping = 0.0, implicit = 0.0;  // N m s/rad
};

template <class T>
inline Coupling<T> coupling_of(const JointParams& joint, const JointInstantOf<T>& at,
                               T motor_inertia, T stretch_half) {
  Coupling<T> c;
  const double half_play = 0.5 * joint.backlash;
  const T reduced = motor_inertia * at.inertia / (motor_inertia + at.inertia);
  // teeth without measured compliance: stiff against everything else the joint does (160 Hz with
  // the reduced inertia)
  c.k = joint.compliance > 0.0 ? T(1.0 / joint.compliance) : reduced * 1000.0 * 1000.0;
  const T d = joint.compliance > 0.0 ? T(joint.compliance_damping) : 0.6 * sqrt_of(c.k * reduced);
  c.stretch = stretch_half - with_sign(T(half_play), stretch_half);
  const T h = at.h;
  // slow enough for the midpoint: second order, no added damping; in contact torque at the end of
  // the step, so that it cannot ring
  const T contact = 0.5 * h * c.k + d;
  c.explicit_damping = c.implicit = contact;
  if (joint.backlash == 0.0) {
    const MaskOf<T> slow = less(h * h * c.k, reduced);
    c.explicit_damping = choose(slow, d, contact);
    c.implicit = choose(slow, 0.25 * h * c.k + implicitness(h * d, reduced) * d, contact);
    return c;
  }
  const MaskOf<T> loose = no_more(abs_of(stretch_half), T(half_play));
  c.stretch = choose(loose, T(0.0), c.stretch);
  c.k = choose(loose, T(0.0), c.k);
  c.explicit_damping = choose(loose, T(0.0), c.explicit_damping);
  c.implicit = choose(loose, T(0.0), c.implicit);
  return c;
}

/// What all forces at the gears add up to: force - damping and stiffness by the own motion.
template <class T>
struct GearForces {
  T force, damping, stiffness;
  Elastic<T> elastic;
};

/// Motor torque, viscous and dry friction at the gears that rub with speed y.
template <class T>
inline GearForces<T> gear_forces(const JointParams& joint, const SlipShares& shares,
                                 const ServoOutputOf<T>& servo, const JointInstantOf<T>& at,
                                 const InnerStateOf<T>& inner, T y, JointPartOf<T>& part) {
  const T h = at.h;
  T motor = servo.torque;
  if (!is_none(joint.gear_error))
    motor = (1.0 - ripple_slope(joint.gear_error, at.q_half)) * servo.torque;
  T viscous = (joint.nominal.viscous + joint.viscous) * thermal_factor(joint, at.warming);
  if (joint.viscous_difference != 0.0) viscous += joint.viscous_difference * with_sign(T(1.0), y);
  GearForces<T> out{motor - viscous * y, viscous + servo.back_emf_damping, T(0.0), {}};
  // the servo's own feedback closes on the same mass
  if (!part.two_mass || joint.encoder_at_motor) {
    out.damping += servo.damping;
    out.stiffness += servo.stiffness;
  }
  const T budget = friction_budget(joint, motor, at, y, inner);
  if (joint.slip_torque > 0.0 && joint.slip_stiffness > 0.0)
    out.elastic = maxwell(joint, shares, h, y, inner);
  MaskOf<T> dry = no_more(T(0.0), T(0.0));  // where no bristle takes the friction's place
  if (joint.presliding_compliance > 0.0) {
    // bristle: dz = y - sigma0 |y| z / budget, torque sigma0 z + sigma1 dz, with the new z
    // throughout
    const MaskOf<T> bends = less(T(0.0), budget);
    const double sigma0 = 1.0 / joint.presliding_compliance;
    const T denominator = 1.0 + h * sigma0 * abs_of(y) / choose(bends, budget, T(1.0));
    const T constant = sigma0 * inner.bristle / denominator +
                       joint.presliding_damping * inner.bristle * (1.0 / denominator - 1.0) / h;
    out.elastic.constant += choose(bends, constant, T(0.0));
    out.elastic.slope +=
        choose(bends, (sigma0 * h + joint.presliding_damping) / denominator, T(0.0));
    part.bristle_denominator = choose(bends, denominator, T(1.0));
    // largest bristle
    part.bristle_gain = choose(bends, budget * joint.presliding_compliance, T(0.0));
    dry = negated(bends);
  }
  if (!any(dry)) return out;
  part.rubs = true;
  const double difference = joint.coulomb_difference;
  // against forward motion, and backward
  part.f_min = choose(dry, -h * max_of(T(0.0), budget + difference), T(0.0));
  part.f_max = choose(dry, h * max_of(T(0.0), budget - difference), T(0.0));
  if (joint.creep_speed > 0.0) {
    part.creeps = true;
    part.slack = choose(less(T(0.0), budget), joint.creep_speed / (h * budget), T(0.0));
  }
  return out;
}

/// The motor as its own mass: its end velocity w' = y0 + f / J' + coupling dq' is eliminated.
template <class T>
inline void add_motor_mass(const JointParams& joint, const JointInstantOf<T>& at,
                           const GearForces<T>& gears, const InnerStateOf<T>& inner, T y,
                           double motor_share, JointPartOf<T>& part) {
  const T h = at.h;
  const T motor_inertia =
      max_of(T(joint.nominal.armature + joint.armature), motor_share * at.inertia);
  const T stretch_half = inner.motor_offset + 0.5 * h * inner.motor_speed_offset;
  const Coupling<T> c = coupling_of(joint, at, motor_inertia, stretch_half);
  const T own = motor_inertia + h * implicitness(h * gears.damping, motor_inertia) * gears.damping +
                0.25 * h * h * gears.stiffness;
  const T P = h * c.implicit;
  const T J = own + P + h * gears.elastic.slope;
  const T sliding = inner.motor_speed_offset;  // motor minus link
  const T spring = h * (c.k * c.stretch + c.explicit_damping * sliding);
  const T elastic = gears.elastic.constant + gears.elastic.slope * y;
  part.y0 = y + (h * (gears.force - elastic) - spring - P * at.dq) / J;
  part.mobility = 1.0 / J;
  part.coupling = P / J;
  part.added = P * (1.0 - part.coupling);
  part.impulse = spring + P * (part.y0 - y) + P * part.coupling * at.dq;
}

/// The joint's part of one implicit step, before the links are solved: what its torque is, and how
/// it answers to the link's change of speed.
template <class T>
inline JointPartOf<T> transmission_step(const JointParams& joint, const SlipShares& shares,
                                        const ServoOutputOf<T>& servo, const JointInstantOf<T>& at,
                                        const InnerStateOf<T>& inner,
                                        const SimulationSettings& settings) {
  JointPartOf<T> part;
  part.two_mass = has_two_masses(joint);
  const T h = at.h;
  const T y = part.two_mass ? at.dq + inner.motor_speed_offset : at.dq;  // where gears rub
  const GearForces<T> gears = gear_forces(joint, shares, servo, at, inner, y, part);
  if (part.two_mass) {
    add_motor_mass(joint, at, gears, inner, y, settings.motor_share, part);
  } else {
    const double armature = joint.nominal.armature + joint.armature;
    const T inertia = at.inertia + armature;
    part.added = armature + h * implicitness(h * gears.damping, inertia) * gears.damping +
                 0.25 * h * h * gears.stiffness + h * gears.elastic.slope;
    part.impulse = h * (gears.force - gears.elastic.constant - gears.elastic.slope * at.dq);
  }
  add_link_forces(joint, at, part);
  return part;
}

/// Advances the inner states with the step's outcome: dq_end of the link, friction impulse f.
template <class T>
inline void finish_transmission(const JointParams& joint, const SlipShares& shares,
                                const JointInstantOf<T>& at, const JointPartOf<T>& part, T dq_end,
                                T f, const SimulationSettings& settings, InnerStateOf<T>& inner) {
  T y = dq_end;
  if (part.two_mass) {
    y = part.y0 + part.mobility * f + part.coupling * dq_end;
    const T offset_speed = y - dq_end;
    inner.motor_offset += 0.5 * at.h * (inner.motor_speed_offset + offset_speed);
    inner.motor_speed_offset = offset_speed;
  }
  if (joint.presliding_compliance > 0.0) {
    const T z = (inner.bristle + at.h * y) / part.bristle_denominator;
    const MaskOf<T> bends = less(T(0.0), part.bristle_gain);
    inner.bristle = choose(bends, clamped(z, -part.bristle_gain, part.bristle_gain), inner.bristle);
  }
  if (joint.slip_torque > 0.0 && joint.slip_stiffness > 0.0)
    advance_maxwell(joint, shares, at.h, y, inner);
  if (joint.dwell_rate != 0.0) {
    inner.rest_time = choose(less(abs_of(y), T(settings.standing)), inner.rest_time + at.h, T(0.0));
  }
}

}  // namespace sanso::diagnose::SANSO_ISA
