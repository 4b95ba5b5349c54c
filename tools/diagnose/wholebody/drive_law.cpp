// Two actuators follow a goal by a law that torques at rest tell.
#include "tools/diagnose/wholebody/drive_law.h"

namespace sanso::diagnose {

std::string drive_unknown(const WholeBody& body) {
  for (std::size_t j = 0; j < body.model.joints.size(); ++j) {
    const JointSettings& s = body.model.joints[j];
    const bool follows = s.actuator == Actuator::position_pd ||
                         (s.actuator == Actuator::dc_servo && s.i_gain == 0.0);
    if (!follows)
      return "the drive of " + body.model.tree.joints[j].name +
             " follows no goal position (position_pd, dc_servo without i_gain)";
  }
  return {};
}

/// Of a dc_servo, per_duty the torque of a full duty at rest; of position_pd kp and kd:
///
///   stiffness = p_gain per_duty
///   damping = d_gain per_duty + torque_constant back_emf / resistance + viscous
DriveLaw law_of(const JointSettings& s) {
  DriveLaw out;
  const double per_duty = s.torque_constant * s.voltage / s.resistance;
  const bool servo = s.actuator == Actuator::dc_servo;
  out.stiffness = servo ? s.p_gain * per_duty : s.kp;
  out.damping = servo ? s.d_gain * per_duty + s.torque_constant * s.back_emf / s.resistance : s.kd;
  out.damping += s.viscous;
  out.torque_constant = s.torque_constant, out.armature = s.armature, out.coulomb = s.coulomb;
  out.lag = s.command_delay_s;
  return out;
}

}  // namespace sanso::diagnose
