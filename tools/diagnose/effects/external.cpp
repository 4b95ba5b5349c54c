// What acts from outside: X1 to X4 of the method page.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> external_effects() {
  constexpr Family F = Family::external;
  constexpr Port P = Port::external;
  return {
      {"air_drag", "X1", "aerodynamic drag", "-drag |dq| dq", F, P, Scope::joint,
       {{"drag", "N m s^2/rad^2", 0, 0, 0.2, 0.02, Unit::drag}},
       true, {{0.02}}, 1, kR2 | kR3 | kR8, 0, "", {"viscous_friction"}, {"high speed"}, "square of the speed", {kTorqueOff, kChirp},
       [](SimParams& p, int j, Theta x) { joint(p, j).air_drag += x[0]; }},
      {"external_push", "X2", "a push", "force (x, y, z) in base axes at the link's centre of mass during [from, from + duration]", F, P, Scope::link,
       {{"x", "N", 0, -50, 50, 2, Unit::force}, {"y", "N", 0, -50, 50, 2, Unit::force}, {"z", "N", 0, -50, 50, 2, Unit::force},
        {"from", "s", 0, 0, 1e4, 0.1, Unit::none, true}, {"duration", "s", 0.1, 0.01, 5, 0.1, Unit::none, true}},
       false, {}, 0, kR2 | kR3 | kR5, 0, "J", {"payload", "tether", "restitution"}, {"isolated in time"}, "isolated in time, not repeated",
       {{Experiment::Kind::setting, "repeat the same motion: a push does not come again"}},
       [](SimParams& p, int j, Theta x) {
         if (x[0] != 0.0 || x[1] != 0.0 || x[2] != 0.0) p.forces.push_back({j, {x[0], x[1], x[2]}, x[3], x[3] + x[4]});
       }},
      {"tether", "X3", "tether or cable drag", "constant force (x, y, z) in base axes at the link's centre of mass", F, P, Scope::link,
       {{"x", "N", 0, -20, 20, 0.5, Unit::force}, {"y", "N", 0, -20, 20, 0.5, Unit::force}, {"z", "N", 0, -20, 20, 0.5, Unit::force}},
       true, {{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}}, 0, kR2 | kR3 | kR5, 0, "J", {"payload", "external_push", "ground_slope", "cable_spring", "link_com"},
       {"standstill", "low speed"}, "constant in the world", {kTilt, kPostures},
       [](SimParams& p, int j, Theta x) {
         if (x[0] != 0.0 || x[1] != 0.0 || x[2] != 0.0) p.forces.push_back({j, {x[0], x[1], x[2]}});
       }},
      {"joint_stop", "X4", "joint stop or self-collision", "-stiffness (q - position) beyond `position`, side +1 above, -1 below", F, P, Scope::joint,
       {{"stiffness", "N m/rad", 0, 0, 500, 10, Unit::stiffness}, {"position", "rad", 1, -3.2, 3.2, 0.05, Unit::angle},
        {"side", "+1 or -1", 1, -1, 1, 1, Unit::none, true}},
       false, {{20, 1, 1}, {20, -1, -1}}, 1, kR2 | kR3, 0, "", {"cable_spring"}, {"near joint limit"}, "only near one end of the range", {kFullRange},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0) return;
         joint(p, j).stop_stiffness = x[0];
         joint(p, j).stop_position = x[1];
         joint(p, j).stop_side = x[2] >= 0.0 ? 1.0 : -1.0;
       }},
  };
}

}  // namespace sanso::diagnose
