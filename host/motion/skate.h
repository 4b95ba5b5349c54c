// What makes a motion one on wheels: the profile it rolls down, how a hand starts it, and how its
// reference is made. Stands in the motion's file as [skate].
#pragma once

#include <string>

namespace sanso::motion {

struct Skate {
  std::string ground = "ramp";  // a profile of shared/grounds
  double push_m_s = 0.0;        // a hand brings the robot to this speed
  double push_s = 0.5;          // within this time, then lets go
  double rolling = 0.015;       // friction of the wheels that the reference counts with
  double kappa = 0.9;           // leg length, of the straight leg
  double lean_m = 0.0;          // centre of mass ahead of the wheels' middle
  double end_x_m = 1.5;         // the reference ends when the wheels are there
  double basis_per_second = 20.0;
};

/// Calls `field(key, value)` for every figure: one list for reading and writing.
template <class S, class Field>
void visit_skate(S& s, Field&& field) {
  field("ground", s.ground);
  field("push_m_s", s.push_m_s);
  field("push_s", s.push_s);
  field("rolling", s.rolling);
  field("kappa", s.kappa);
  field("lean_m", s.lean_m);
  field("end_x_m", s.end_x_m);
  field("basis_per_second", s.basis_per_second);
}

}  // namespace sanso::motion
