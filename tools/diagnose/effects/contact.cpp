// Ground contact: C1 to C6 of the method page. A fixed base stands on nothing: listed so that a
// diagnosis can say that they were not tested; none has a simulation here.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

Effect ground(Effect effect) {
  return of_chapter({Family::contact, Port::contact, Scope::robot, kR2 | kR5 | kR6},
                    std::move(effect));
}

Effect ground_slope() {
  return ground({
      .id = "ground_slope",
      .code = "C1",
      .name = "slope of the floor",
      .form = "gravity turned",
      .parameters = {{"x", "rad", 0, -0.09, 0.09, 0.02}, {"y", "rad", 0, -0.09, 0.09, 0.02}},
      .needs = kGround,
      .cluster = "E",
      .confounders = {"imu_misalignment", "pose_tilt", "link_com", "encoder_offset"},
      .regimes = {"stance"},
      .signature = "constant in the world",
      .whole = WholeFigure::slope,
  });
}

Effect contact_compliance() {
  return ground({
      .id = "contact_compliance",
      .code = "C2",
      .name = "stiffness and damping of the contact",
      .form = "log scale of stiffness",
      .parameters = {{"stiffness", "log", 0, -2.3, 2.3, 0.5},
                     {"damping", "log", 0, -2.3, 2.3, 0.5}},
      .needs = kGround,
      .cluster = "G",
      .confounders = {"joint_compliance", "restitution"},
      .regimes = {"touchdown"},
      .signature = "touchdown +-40 ms",
      .whole = WholeFigure::compliance,
  });
}

Effect contact_friction() {
  return ground({
      .id = "contact_friction",
      .code = "C3",
      .name = "friction coefficient of the ground",
      .form = "mu",
      .parameters = {{"mu", "-", 0.8, 0.1, 1.5, 0.1}},
      .smooth = false,
      .needs = kGround,
      .confounders = {"sole_geometry"},
      .regimes = {"slip"},
      .signature = "only when slipping",
      .whole = WholeFigure::friction,
  });
}

Effect restitution() {
  return ground({
      .id = "restitution",
      .code = "C4",
      .name = "restitution",
      .form = "e",
      .parameters = {{"e", "-", 0, 0, 0.5, 0.1}},
      .smooth = false,
      .sign = 1,
      .needs = kGround,
      .cluster = "G",
      .confounders = {"contact_compliance"},
      .regimes = {"touchdown"},
      .signature = "the first 20 ms",
      .whole = WholeFigure::restitution,
  });
}

Effect sole_geometry() {
  return ground({
      .id = "sole_geometry",
      .code = "C5",
      .name = "geometry of the sole",
      .form = "corner offset",
      .parameters = {{"offset", "m", 0, -0.006, 0.006, 0.002}},
      .needs = kGround,
      .confounders = {"link_com", "contact_friction"},
      .regimes = {"stance"},
      .signature = "centre of pressure at the edge",
      .whole = WholeFigure::sole_shape,
  });
}

Effect rolling_resistance() {
  return ground({
      .id = "rolling_resistance",
      .code = "C6",
      .name = "rolling resistance or wheel slip",
      .form = "-c N sign(v)",
      .parameters = {{"c", "-", 0, 0, 0.1, 0.01}},
      .smooth = false,
      .sign = 1,
      .needs = kGround,
      .confounders = {"coulomb_friction"},
      .regimes = {"stance"},
      .signature = "wheels only",
      .whole = WholeFigure::rolling,
  });
}

}  // namespace

std::vector<Effect> contact_effects() {
  return {ground_slope(), contact_compliance(), contact_friction(),
          restitution(),  sole_geometry(),      rolling_resistance()};
}

}  // namespace sanso::diagnose
