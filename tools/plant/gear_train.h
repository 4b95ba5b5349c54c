// One servo from voltage to joint torque: DC motor, friction, gear with play and elasticity. The
// motor is a mass of its own, joined to the link by a spring that does not pull inside the play;
// the link is MuJoCo's.
#pragma once

namespace sanso::plant {

struct GearTrainParameters {
  double resistance_ohm, torque_constant_Nm_A, back_emf_V_s;
  double motor_inertia_kgm2, stiffness_Nm_rad, damping_Nms_rad, backlash_rad;
  double coulomb_Nm, stribeck_extra_Nm, stribeck_velocity_rad_s, load_friction, viscous_Nms_rad;
};

struct GearTrain {
  double angle_rad = 0;  // motor, seen at the output
  double rate_rad_s = 0;
  double current_A = 0;
  double motor_torque_Nm = 0;  // before friction
  double gear_torque_Nm = 0;   // what reaches the link

  /// Puts the motor where the link is, at rest, in the middle of the play.
  void place(double link_angle_rad) { *this = GearTrain{link_angle_rad, 0, 0, 0, 0}; }

  /// One step of `h` seconds. `powered` false: bridge open, no current and no back-EMF braking.
  /// Spring, damping and back-EMF are implicit in the motor's rate; dry friction is a bounded
  /// impulse against it, so that a stuck motor stays exactly still.
  void step(const GearTrainParameters& p, double h, bool powered, double volt,
            double link_angle_rad, double link_rate_rad_s);
};

}  // namespace sanso::plant
