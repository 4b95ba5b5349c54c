// All forces of the transmission as constant plus slope times the velocity at the end of the
// step, so that stiff ones stay stable.
#include "tools/diagnose/sim/transmission.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sanso::diagnose {
namespace {

// rad/s; slower counts as rest for dwell-time stiction: a count of a 12-bit encoder in 75 ms, which
// a recording does not tell from standing
constexpr double kMovingSpeed = 0.02;
// motor inertia, when none is known, as a share of the link's
constexpr double kMinimumMotorShare = 0.02;
constexpr std::size_t kSlipElements = 4;

double thermal_factor(const JointParams& joint, double warming) {
  return joint.friction_temperature == 0.0 ? 1.0 : std::exp(-joint.friction_temperature * warming);
}

/// Friction torque available at speed y under motor torque and external torque, N m, before the
/// sign of motion.
double friction_budget(const JointParams& joint, double motor, const JointInstant& at, double y,
                       const InnerState& inner) {
  const double speed = std::abs(y);
  double budget = joint.nominal.coulomb + joint.coulomb;
  if (joint.stribeck != 0.0) {
    budget +=
        joint.stribeck * std::exp(-std::pow(speed / joint.stribeck_speed, joint.stribeck_shape));
  }
  const double load = std::abs(motor - at.external);
  if (joint.load_friction != 0.0) budget += joint.load_friction * load;
  if (joint.drive_friction != 0.0 || joint.backdrive_friction != 0.0) {
    budget += std::abs(joint.drive_friction * motor - joint.backdrive_friction * at.external);
  }
  if (joint.quadratic_load_friction != 0.0) budget += joint.quadratic_load_friction * load * load;
  if (!joint.friction_ripple.zero()) budget += ripple_at(joint.friction_ripple, at.q_half);
  if (joint.static_friction != 0.0 || joint.dwell_rate != 0.0) {
    const double at_rest = std::exp(-speed / joint.static_speed);
    const double grown = 1.0 + joint.dwell_rate * std::log1p(inner.rest_time);
    budget += at_rest * (joint.static_friction * grown +
                         (joint.nominal.coulomb + joint.coulomb) * (grown - 1.0));
  }
  budget = std::max(0.0, budget) * thermal_factor(joint, at.warming);
  if (joint.efficiency != 1.0) {
    // lost when driving: (1 - eta) tau; held back when driven: (1/eta - 1) tau
    const bool driving = motor * y >= 0.0;
    budget += std::abs(motor) * (driving ? 1.0 - joint.efficiency : 1.0 / joint.efficiency - 1.0);
  }
  return budget;
}

/// Share of the implicit end in a velocity-proportional force: 1/2 (midpoint) for slow decay,
/// towards 1 for fast decay, such that the scalar linear decay is integrated to third order.
double implicitness(double h_damping, double inertia) {
  const double z = h_damping / inertia;
  return z > 0.0 ? 0.5 + z / (12.0 + 2.0 * z) : 0.5;
}

/// Fully implicit damping of the presliding bristle and of the Maxwell elements that stick: force =
/// constant + slope y'.
struct Elastic {
  double constant = 0.0, slope = 0.0;  // N m, N m s/rad
};

/// Shares of the Maxwell elements in the torque: those of (i + 1)^spread.
std::array<double, kSlipElements> slip_shares(double spread) {
  const double two = std::pow(2.0, spread), three = std::pow(3.0, spread);
  const double total = 1.0 + two + three + two * two;
  return {1.0 / total, two / total, three / total, two * two / total};
}

Elastic maxwell(const JointParams& joint, double h, double y, const InnerState& inner) {
  Elastic e;
  const double stiffness = joint.slip_stiffness / kSlipElements;
  const auto shares = slip_shares(joint.slip_spread);
  for (std::size_t i = 0; i < kSlipElements; ++i) {
    const double limit = joint.slip_torque * shares[i];
    if (std::abs(stiffness * (inner.slip[i] + h * y)) < limit) {
      e.constant += stiffness * inner.slip[i];
      e.slope += stiffness * h;
    } else {
      e.constant += std::copysign(limit, inner.slip[i] + h * y);
    }
  }
  return e;
}

void advance_maxwell(const JointParams& joint, double h, double y, InnerState& inner) {
  const double stiffness = joint.slip_stiffness / kSlipElements;
  const auto shares = slip_shares(joint.slip_spread);
  for (std::size_t i = 0; i < kSlipElements; ++i) {
    const double limit = joint.slip_torque * shares[i] / stiffness;
    inner.slip[i] = std::clamp(inner.slip[i] + h * y, -limit, limit);
  }
}

/// Springs, stops, cogging and drag that act on the link itself.
void add_link_forces(const JointParams& joint, const JointInstant& at, JointPart& part) {
  double force = 0.0, stiffness = 0.0, damping = 0.0;
  if (joint.spring != 0.0 || joint.spring_torque != 0.0) {
    force += joint.spring_torque - joint.spring * at.q_half;
    stiffness += std::max(0.0, joint.spring);
  }
  if (!joint.cogging.zero()) force += ripple_at(joint.cogging, at.q_half);
  if (joint.air_drag != 0.0) {
    force -= joint.air_drag * std::abs(at.dq) * at.dq;
    damping += 2.0 * joint.air_drag * std::abs(at.dq);
  }
  if (joint.stop_stiffness > 0.0 && joint.stop_side * (at.q_half - joint.stop_position) > 0.0) {
    const double d = joint.stop_loss * std::sqrt(joint.stop_stiffness * at.inertia);
    force -= joint.stop_stiffness * (at.q_half - joint.stop_position) + d * at.dq;
    stiffness += joint.stop_stiffness;
    damping += d;
  }
  part.passive_torque += force;
  part.impulse += at.h * force;
  part.added +=
      at.h * implicitness(at.h * damping, at.inertia) * damping + 0.25 * at.h * at.h * stiffness;
}

/// Spring and damper between motor and link over one step: torque k stretch + explicit_damping (w -
/// v) + implicit (Dw - Dv).
struct Coupling {
  double stretch = 0.0;                           // rad at mid-step, beyond the play; 0 inside it
  double k = 0.0;                                 // N m/rad; 0 inside the play
  double explicit_damping = 0.0, implicit = 0.0;  // N m s/rad
};
Coupling coupling_of(const JointParams& joint, const JointInstant& at, double motor_inertia,
                     double stretch_half) {
  Coupling c;
  const double half_play = 0.5 * joint.backlash;
  const double reduced = motor_inertia * at.inertia / (motor_inertia + at.inertia);
  // teeth without measured compliance: stiff against everything else the joint does (160 Hz with
  // the reduced inertia)
  c.k = joint.compliance > 0.0 ? 1.0 / joint.compliance : reduced * 1000.0 * 1000.0;
  const double d =
      joint.compliance > 0.0 ? joint.compliance_damping : 0.6 * std::sqrt(c.k * reduced);
  if (std::abs(stretch_half) <= half_play && joint.backlash > 0.0) {
    c.k = 0.0;
    return c;
  }
  c.stretch = stretch_half - std::copysign(half_play, stretch_half);
  const double h = at.h;
  if (joint.backlash == 0.0 &&
      h * h * c.k < reduced) {  // slow enough for the midpoint: second order, no added damping
    c.explicit_damping = d;
    c.implicit = 0.25 * h * c.k + implicitness(h * d, reduced) * d;
  } else {  // contact: torque at the end of the step, so that it cannot ring
    c.explicit_damping = c.implicit = 0.5 * h * c.k + d;
  }
  return c;
}

}  // namespace

bool has_memory(const JointParams& j) {
  return is_two_mass(j) || j.presliding_compliance > 0.0 || j.slip_torque > 0.0 ||
         j.output_filter > 0.0 || j.integral_rate > 0.0 || j.nominal.i_gain > 0.0 ||
         j.profile_speed != kNone || j.profile_acceleration != kNone || j.dwell_rate != 0.0 ||
         j.derating != 0.0 || j.friction_temperature != 0.0 || j.velocity_filter > 0.0;
}

JointPart transmission_step(const JointParams& joint, const ServoOutput& servo,
                            const JointInstant& at, const InnerState& inner) {
  JointPart part;
  part.two_mass = is_two_mass(joint);
  const double h = at.h;
  const double armature = joint.nominal.armature + joint.armature;
  const double ratio =
      joint.gear_error.zero() ? 1.0 : 1.0 - ripple_slope(joint.gear_error, at.q_half);
  const double motor = ratio * servo.torque;
  const double y = part.two_mass ? at.dq + inner.motor_speed_offset : at.dq;  // where gears rub

  double viscous = (joint.nominal.viscous + joint.viscous) * thermal_factor(joint, at.warming);
  if (joint.viscous_difference != 0.0) viscous += std::copysign(joint.viscous_difference, y);
  double force = motor - viscous * y;
  double damping = viscous + servo.back_emf_damping;
  double stiffness = 0.0;
  if (!part.two_mass ||
      joint.encoder_at_motor) {  // the servo's own feedback closes on the same mass
    damping += servo.damping;
    stiffness += servo.stiffness;
  }

  const double budget = friction_budget(joint, motor, at, y, inner);
  Elastic elastic;
  if (joint.slip_torque > 0.0 && joint.slip_stiffness > 0.0) elastic = maxwell(joint, h, y, inner);
  if (joint.presliding_compliance > 0.0 && budget > 0.0) {
    // bristle: dz = y - sigma0 |y| z / budget, torque sigma0 z + sigma1 dz, with the new z
    // throughout
    const double sigma0 = 1.0 / joint.presliding_compliance;
    const double denominator = 1.0 + h * sigma0 * std::abs(y) / budget;
    elastic.constant += sigma0 * inner.bristle / denominator +
                        joint.presliding_damping * inner.bristle * (1.0 / denominator - 1.0) / h;
    elastic.slope += (sigma0 * h + joint.presliding_damping) / denominator;
    part.bristle_denominator = denominator;
    part.bristle_gain = budget * joint.presliding_compliance;  // largest bristle
  } else {
    const double difference = joint.coulomb_difference;
    part.f_min = -h * std::max(0.0, budget + difference);  // against forward motion
    part.f_max = h * std::max(0.0, budget - difference);
  }

  if (!part.two_mass) {
    const double inertia = at.inertia + armature;
    part.added = armature + h * implicitness(h * damping, inertia) * damping +
                 0.25 * h * h * stiffness + h * elastic.slope;
    part.impulse = h * (force - elastic.constant - elastic.slope * at.dq);
    add_link_forces(joint, at, part);
    return part;
  }

  // motor as its own mass: eliminate its end velocity w' = y0 + f / J' + coupling dq'
  const double motor_inertia = std::max(armature, kMinimumMotorShare * at.inertia);
  const double stretch_half = inner.motor_offset + 0.5 * h * inner.motor_speed_offset;
  const Coupling c = coupling_of(joint, at, motor_inertia, stretch_half);
  const double own = motor_inertia + h * implicitness(h * damping, motor_inertia) * damping +
                     0.25 * h * h * stiffness;
  const double P = h * c.implicit;
  const double J = own + P + h * elastic.slope;
  const double sliding = inner.motor_speed_offset;  // motor minus link
  const double spring = h * (c.k * c.stretch + c.explicit_damping * sliding);
  part.y0 = y + (h * (force - elastic.constant - elastic.slope * y) - spring - P * at.dq) / J;
  part.mobility = 1.0 / J;
  part.coupling = P / J;
  part.added = P * (1.0 - part.coupling);
  part.impulse = spring + P * (part.y0 - y) + P * part.coupling * at.dq;
  add_link_forces(joint, at, part);
  return part;
}

void finish_transmission(const JointParams& joint, const JointInstant& at, const JointPart& part,
                         double dq_end, double f, InnerState& inner) {
  const double y_end = part.y0 + part.mobility * f + part.coupling * dq_end;
  const double y = part.two_mass ? y_end : dq_end;
  if (part.two_mass) {
    const double offset_speed = y_end - dq_end;
    inner.motor_offset += 0.5 * at.h * (inner.motor_speed_offset + offset_speed);
    inner.motor_speed_offset = offset_speed;
  }
  if (part.bristle_gain > 0.0) {
    const double z = (inner.bristle + at.h * y) / part.bristle_denominator;
    inner.bristle = std::clamp(z, -part.bristle_gain, part.bristle_gain);
  }
  if (joint.slip_torque > 0.0 && joint.slip_stiffness > 0.0) advance_maxwell(joint, at.h, y, inner);
  if (joint.dwell_rate != 0.0)
    inner.rest_time = std::abs(y) < kMovingSpeed ? inner.rest_time + at.h : 0.0;
}

}  // namespace sanso::diagnose
