// What makes a motion a jog that flies: how often, how high, and how a foot leaves the ground.
// Stands in the motion's file as [flight].
#pragma once

namespace sanso::motion {

struct FlightJog {
  int steps = 12;              // the last one closes
  double step_m = 0.04;        // a foot ahead of the other one
  double stand_s = 0.5;        // before and after
  double period_s = 0.318;     // from lift to lift
  double flight_s = 0.058;     // asked for; what comes of it is shorter
  double lift_off_m_s = 0.24;  // of the trunk
  double absorb_s = 0.062;     // from touch-down until it rises again
  double kappa = 0.822;        // leg length when standing, of the straight leg
  double swing_height_m = 0.033;
  double swing_sharpness = 2.8;
  double swing_dwell = 0.05;
  double heel_rad = 0.27;      // foot about its front edge at lift-off
  double heel_up_s = 0.092;    // before it
  double heel_down_s = 0.042;  // and after it, until the toes are
  double toe_rad = 0.18;       // up so far, level again at touch-down
  double basis_per_second = 50.0;
};

/// Calls `field(key, value)` for every figure: one list for reading and writing.
template <class J, class Field>
void visit_flight_jog(J& j, Field&& field) {
  field("steps", j.steps);
  field("step_m", j.step_m);
  field("stand_s", j.stand_s);
  field("period_s", j.period_s);
  field("flight_s", j.flight_s);
  field("lift_off_m_s", j.lift_off_m_s);
  field("absorb_s", j.absorb_s);
  field("kappa", j.kappa);
  field("swing_height_m", j.swing_height_m);
  field("swing_sharpness", j.swing_sharpness);
  field("swing_dwell", j.swing_dwell);
  field("heel_rad", j.heel_rad);
  field("heel_up_s", j.heel_up_s);
  field("heel_down_s", j.heel_down_s);
  field("toe_rad", j.toe_rad);
  field("basis_per_second", j.basis_per_second);
}

}  // namespace sanso::motion
