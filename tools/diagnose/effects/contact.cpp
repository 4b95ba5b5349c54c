// Ground contact: C1 to C6 of the method page. A fixed base stands on nothing: listed so that a diagnosis can say that
// they were not tested; none has a simulation here.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> contact_effects() {
  constexpr Family F = Family::contact;
  constexpr Port P = Port::contact;
  constexpr Scope S = Scope::robot;
  constexpr unsigned R = kR2 | kR5 | kR6;
  return {
      {
          .id = "ground_slope",
          .code = "C1",
          .name = "slope of the floor",
          .form = "gravity turned",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"x", "rad", 0, -0.09, 0.09, 0.02}, {"y", "rad", 0, -0.09, 0.09, 0.02}},
          .residuals = R,
          .needs = kGround,
          .cluster = "E",
          .confounders = {"imu_misalignment", "link_com", "encoder_offset"},
          .regimes = {"stance"},
          .signature = "constant in the world",
      },
      {
          .id = "contact_compliance",
          .code = "C2",
          .name = "stiffness and damping of the contact",
          .form = "log scale of stiffness",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"stiffness", "log", 0, -2.3, 2.3, 0.5}, {"damping", "log", 0, -2.3, 2.3, 0.5}},
          .residuals = R,
          .needs = kGround,
          .cluster = "G",
          .confounders = {"joint_compliance", "restitution"},
          .regimes = {"touchdown"},
          .signature = "touchdown +-40 ms",
      },
      {
          .id = "contact_friction",
          .code = "C3",
          .name = "friction coefficient of the ground",
          .form = "mu",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"mu", "-", 0.8, 0.1, 1.5, 0.1}},
          .smooth = false,
          .residuals = R,
          .needs = kGround,
          .confounders = {"sole_geometry"},
          .regimes = {"slip"},
          .signature = "only when slipping",
      },
      {
          .id = "restitution",
          .code = "C4",
          .name = "restitution",
          .form = "e",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"e", "-", 0, 0, 0.5, 0.1}},
          .smooth = false,
          .sign = 1,
          .residuals = R,
          .needs = kGround,
          .cluster = "G",
          .confounders = {"contact_compliance"},
          .regimes = {"touchdown"},
          .signature = "the first 20 ms",
      },
      {
          .id = "sole_geometry",
          .code = "C5",
          .name = "geometry of the sole",
          .form = "corner offset",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"offset", "m", 0, -0.006, 0.006, 0.002}},
          .residuals = R,
          .needs = kGround,
          .confounders = {"link_com", "contact_friction"},
          .regimes = {"stance"},
          .signature = "centre of pressure at the edge",
      },
      {
          .id = "rolling_resistance",
          .code = "C6",
          .name = "rolling resistance or wheel slip",
          .form = "-c N sign(v)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"c", "-", 0, 0, 0.1, 0.01}},
          .smooth = false,
          .sign = 1,
          .residuals = R,
          .needs = kGround,
          .confounders = {"coulomb_friction"},
          .regimes = {"stance"},
          .signature = "wheels only",
      },
  };
}

}  // namespace sanso::diagnose
