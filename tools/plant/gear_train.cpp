// The spring beyond the play, the motor and the friction, once a step of the physics.
#include "tools/plant/gear_train.h"

#include <algorithm>
#include <cmath>

namespace sanso::plant {

void GearTrain::step(const GearTrainParameters& p, double h, bool powered, double volt,
                     double link_angle_rad, double link_rate_rad_s) {
  // spring beyond the play
  const double gap = angle_rad - link_angle_rad;
  const double half = 0.5 * p.backlash_rad;
  const double stretch = gap - std::clamp(gap, -half, half);
  const bool engaged = stretch != 0.0 || half == 0.0;
  const double k = engaged ? p.stiffness_Nm_rad : 0.0;
  const double d = engaged ? p.damping_Nms_rad : 0.0;

  // J (w' - w) = h (drive - emf w' - viscous w' - gear(w')), gear(w') = k (stretch + h (w' - dq)) +
  // d (w' - dq)
  const double emf = powered ? p.torque_constant_Nm_A * p.back_emf_V_s / p.resistance_ohm : 0.0;
  const double drive = powered ? p.torque_constant_Nm_A * volt / p.resistance_ohm : 0.0;
  const double inertia = p.motor_inertia_kgm2 + h * (emf + p.viscous_Nms_rad + d + h * k);
  const double free_rate = (p.motor_inertia_kgm2 * rate_rad_s +
                            h * (drive - k * stretch + (d + h * k) * link_rate_rad_s)) /
                           inertia;

  // dry friction: Coulomb with Stribeck's rise at low speed, growing with the load on the gear
  const double slow = rate_rad_s / p.stribeck_velocity_rad_s;
  const double friction = p.coulomb_Nm + p.stribeck_extra_Nm * std::exp(-slow * slow) +
                          p.load_friction * std::abs(gear_torque_Nm);
  const double moving = std::max(0.0, std::abs(free_rate) - h * friction / inertia);
  const double rate = std::copysign(moving, free_rate);

  const double relative = rate - link_rate_rad_s;
  double gear = k * (stretch + h * relative) + d * relative;
  if (half > 0.0 && gear * stretch < 0.0) gear = 0.0;  // teeth push, they do not pull
  gear_torque_Nm = gear;
  current_A = powered ? (volt - p.back_emf_V_s * rate) / p.resistance_ohm : 0.0;
  motor_torque_Nm = p.torque_constant_Nm_A * current_A;
  rate_rad_s = rate;
  angle_rad += h * rate;
}

}  // namespace sanso::plant
