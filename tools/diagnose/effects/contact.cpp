// Ground contact: C1 to C6 of the method page. A fixed base stands on nothing: listed so that a diagnosis can say that they
// were not tested; none has a simulation here.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> contact_effects() {
  constexpr Family F = Family::contact;
  constexpr Port P = Port::contact;
  constexpr Scope S = Scope::robot;
  constexpr unsigned R = kR2 | kR5 | kR6;
  return {
      {"ground_slope", "C1", "slope of the floor", "gravity turned", F, P, S,
       {{"x", "rad", 0, -0.09, 0.09, 0.02}, {"y", "rad", 0, -0.09, 0.09, 0.02}},
       true, {}, 0, R, kGround, "E", {"imu_misalignment", "link_com", "encoder_offset"}, {"stance"}, "constant in the world", {}, nullptr},
      {"contact_compliance", "C2", "stiffness and damping of the contact", "log scale of stiffness", F, P, S,
       {{"stiffness", "log", 0, -2.3, 2.3, 0.5}, {"damping", "log", 0, -2.3, 2.3, 0.5}},
       true, {}, 0, R, kGround, "G", {"joint_compliance", "restitution"}, {"touchdown"}, "touchdown +-40 ms", {}, nullptr},
      {"contact_friction", "C3", "friction coefficient of the ground", "mu", F, P, S,
       {{"mu", "-", 0.8, 0.1, 1.5, 0.1}},
       false, {}, 0, R, kGround, "", {"sole_geometry"}, {"slip"}, "only when slipping", {}, nullptr},
      {"restitution", "C4", "restitution", "e", F, P, S,
       {{"e", "-", 0, 0, 0.5, 0.1}},
       false, {}, 1, R, kGround, "G", {"contact_compliance"}, {"touchdown"}, "the first 20 ms", {}, nullptr},
      {"sole_geometry", "C5", "geometry of the sole", "corner offset", F, P, S,
       {{"offset", "m", 0, -0.006, 0.006, 0.002}},
       true, {}, 0, R, kGround, "", {"link_com", "contact_friction"}, {"stance"}, "centre of pressure at the edge", {}, nullptr},
      {"rolling_resistance", "C6", "rolling resistance or wheel slip", "-c N sign(v)", F, P, S,
       {{"c", "-", 0, 0, 0.1, 0.01}},
       false, {}, 1, R, kGround, "", {"coulomb_friction"}, {"stance"}, "wheels only", {}, nullptr},
  };
}

}  // namespace sanso::diagnose
