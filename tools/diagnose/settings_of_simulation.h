// What a joint of unknown size is measured by.
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
  }
};

}  // namespace sanso::diagnose
