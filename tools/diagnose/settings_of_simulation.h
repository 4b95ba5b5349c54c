// What a simulation supposes that no model states, where it stops calculating; and what a joint of
// unknown size is measured by.
#pragma once

namespace sanso::diagnose {

/// The joint whose figures the bounds and typical sizes of the library are: an XM430-W350 at 12 V
/// on a leg of an OP3. At any other joint they grow with what it is in comparison.
struct LibrarySettings {
  double torque = 4.1;
  double speed = 4.82;
  double inertia = 0.045;
  double current = 2.3;
  double length = 0.1;
  double reserve = 3.0;
  double periods = 1.75;
  template <class Field>
  void visit(Field&& field) {
    field("torque", torque, "N m", 0.001, 10000.0,
          "stall torque of that servo, from its data sheet");
    field("speed", speed, "rad/s", 0.01, 1000.0, "its speed without load: 46 turns a minute");
    field("inertia", inertia, "kg m^2", 1e-06, 1000.0, "what its joint turns, the rotor included");
    field("current", current, "A", 0.001, 1000.0, "its stall current, from its data sheet");
    field("length", length, "m", 0.001, 100.0, "from its joint to its link's centre of mass");
    field("reserve", reserve, "factor", 0.5, 100.0,
          "times the largest torque asked for: what a joint can do where no motor is stated");
    field("periods", periods, "periods", 0.1, 100.0,
          "of a ripple that its joint goes through, at least: fewer may be a part of any bend");
  }
};

/// What every simulation takes for granted. Held by its parameters (SimParams).
struct SimulationSettings {
  double held = 3.0;
  double tree_refresh = 0.01;
  double standing = 0.02;
  double motor_share = 0.02;
  double leaning = 3.0;
  double own_inertia = 0.1;
  double thermal_resistance = 8.0;
  double thermal_time = 300.0;
  int friction_sweeps = 30;
  double friction_settled = 1e-9;
  double least_inertia = 1e-9;
  double diverged = 1e4;
  template <class Field>
  void visit(Field&& field) {
    field(
        "held", held, "s", 0.01, 1000.0,
        "that servos held their posture before a recording: a slow integral carries a part of it");
    field(
        "tree_refresh", tree_refresh, "s", 0.0001, 1.0,
        "between two inertias of a tree that follows: 3 degrees at 5 rad/s, a change by percents");
    field("standing", standing, "rad/s", 1e-06, 1.0,
          "slower is rest, for friction that grows with it: a count of a 12-bit encoder in 75 ms");
    field("motor_share", motor_share, "share of the link's", 0.0001, 1.0,
          "inertia of a motor behind play, at least: where none is known");
    field("leaning", leaning, "rad/s^2", 0.01, 1000.0,
          "of a link across its play that no noise of a smoothed motion makes: it leans on teeth");
    field("own_inertia", own_inertia, "share", 0.001, 0.9,
          "of a body's inertia about its centre of mass that an effect must leave it");
    field("thermal_resistance", thermal_resistance, "K/W", 0.01, 1000.0,
          "winding to case of a small servo; only scales what heat does where none was recorded");
    field("thermal_time", thermal_time, "s", 1.0, 100000.0, "in which such a winding warms");
    field("friction_sweeps", friction_sweeps, "sweeps", 1, 1000,
          "of projected Gauss-Seidel; joints couple weakly, 3 to 6 are typical");
    field("friction_settled", friction_settled, "rad/s", 1e-15, 0.001,
          "a sweep that changes less is the last");
    field("least_inertia", least_inertia, "kg m^2", 1e-15, 1e-05,
          "of a joint: links without inertia still move");
    field("diverged", diverged, "rad/s", 50.0, 1e8, "from here a motion is none");
  }
  bool operator==(const SimulationSettings&) const = default;
};

}  // namespace sanso::diagnose
