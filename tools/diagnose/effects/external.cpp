// What acts from outside: X1 to X4 of the method page.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

Effect on_joint(Effect effect) {
  return of_chapter({Family::external, Port::external, Scope::joint, kR2 | kR3 | kR5},
                    std::move(effect));
}
Effect on_link(Effect effect) {
  return of_chapter({Family::external, Port::external, Scope::link, kR2 | kR3 | kR5},
                    std::move(effect));
}

Effect air_drag() {
  return on_joint({
      .id = "air_drag",
      .code = "X1",
      .name = "aerodynamic drag",
      .form = "-drag |dq| dq",
      .parameters = {{"drag", "N m s^2/rad^2", 0, 0, 0.2, 0.02, Unit::drag}},
      .probes = {{0.02}},
      .sign = 1,
      .residuals = kR2 | kR3 | kR8,
      .confounders = {"viscous_friction"},
      .regimes = {"high speed"},
      .signature = "square of the speed",
      .experiments = {kTorqueOff, kChirp},
      .effort = {.kind = EffortKind::joint, .order = 8},
      .apply = adds(&JointParams::air_drag),
  });
}

Effect external_push() {
  return on_link({
      .id = "external_push",
      .code = "X2",
      .name = "a push",
      .form = "force (x, y, z) in base axes at the link's centre of mass during [from, from + "
              "duration]",
      .parameters = {{"x", "N", 0, -50, 50, 2, Unit::force},
                     {"y", "N", 0, -50, 50, 2, Unit::force},
                     {"z", "N", 0, -50, 50, 2, Unit::force},
                     {"from", "s", 0, 0, 1e4, 0.1, Unit::none, true, Role::event},
                     {"duration", "s", 0.1, 0.01, 5, 0.1, Unit::none, true, Role::duration}},
      .smooth = false,
      .probes = {{2, 0, 0, 0, 0.25}, {0, 2, 0, 0, 0.25}, {0, 0, 2, 0, 0.25}},
      .cluster = "J",
      .confounders = {"payload", "tether", "restitution"},
      .regimes = {"isolated in time"},
      .signature = "isolated in time, not repeated",
      .experiments = {{Experiment::Kind::setting,
                       "repeat the same motion: a push does not come again"}},
      .whole = WholeFigure::push,
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] != 0.0 || x[1] != 0.0 || x[2] != 0.0)
              p.forces.push_back({j, {x[0], x[1], x[2]}, x[3], x[3] + x[4]});
          },
  });
}

Effect tether() {
  return on_link({
      .id = "tether",
      .code = "X3",
      .name = "tether or cable drag",
      .form = "constant force (x, y, z) in base axes at the link's centre of mass",
      .parameters = {{"x", "N", 0, -20, 20, 0.5, Unit::force},
                     {"y", "N", 0, -20, 20, 0.5, Unit::force},
                     {"z", "N", 0, -20, 20, 0.5, Unit::force}},
      .terms = kOfAngle,
      .probes = {{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 0.5}},
      .cluster = "J",
      .confounders = {"payload", "external_push", "ground_slope", "cable_spring", "link_com"},
      .regimes = {"standstill", "low speed"},
      .signature = "constant in the world",
      .experiments = {kTilt, kPostures},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] != 0.0 || x[1] != 0.0 || x[2] != 0.0)
              p.forces.push_back({j, {x[0], x[1], x[2]}});
          },
  });
}

Effect joint_stop() {
  return on_joint({
      .id = "joint_stop",
      .code = "X4",
      .name = "joint stop or self-collision",
      .form = "-stiffness (q - position) - loss sqrt(stiffness inertia) dq beyond `position`, "
              "side +1 above, -1 below",
      .parameters = {{"stiffness", "N m/rad", 0, 0, 500, 1, Unit::stiffness},
                     {"position", "rad", 1, -3.2, 3.2, 0.05, Unit::angle, false, Role::position},
                     {"side", "+1 or -1", 1, -1, 1, 1, Unit::none, true},
                     {"loss", "-", 0, 0, 2, 0.2}},
      .smooth = false,
      .terms = kOfAngle,
      // a bundle of cables that the link runs into, and metal
      .probes = {{1, 1, 1, 0}, {1, -1, -1, 0}, {20, 1, 1, 0}, {20, -1, -1, 0}},
      .sign = 1,
      .residuals = kR2 | kR3,
      .confounders = {"cable_spring"},
      // no body against a body gives way so far: a cord or a cable that becomes taut there does
      .yielding = {"tether", "cable_spring"},
      .regimes = {"near joint limit"},
      .signature = "only near one end of the range",
      .experiments = {kFullRange},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] == 0.0) return;
            joint(p, j).stop_stiffness = x[0];
            joint(p, j).stop_position = x[1];
            joint(p, j).stop_side = x[2] >= 0.0 ? 1.0 : -1.0;
            joint(p, j).stop_loss = x[3];
          },
  });
}

}  // namespace

std::vector<Effect> external_effects() {
  return {air_drag(), external_push(), tether(), joint_stop()};
}

}  // namespace sanso::diagnose
