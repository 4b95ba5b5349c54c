// Every law slides at the same level; they differ in how they get there from rest.
#include "tools/conceal/hidden_friction.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sanso::conceal {
namespace {

constexpr double kCreepSpeed = 0.01;  // rad/s at which the arctangent is half of its level

/// LuGre bristle: exact solution of dz/dt = v - s0 |v| z / g.
double lugre(const JointTruth& j, double rate, double level, double h, double& z) {
  const double speed = std::abs(rate);
  const double settled = std::copysign(level / j.bristle_stiffness, rate);
  const double before = z;
  z = speed > 0 ? settled + (z - settled) * std::exp(-j.bristle_stiffness * speed * h / level) : z;
  return j.bristle_stiffness * z + j.bristle_damping * (z - before) / h;
}

/// Dahl's law with exponent 2: dz/dt = v (1 - s0 z sgn(v) / g)^2. With y in the bracket that is
/// dy/dt = -(s0 |v| / g) y^2, solved exactly; a bristle beyond its level slides at once.
double dahl(const JointTruth& j, double rate, double level, double h, double& z) {
  if (rate == 0) return j.bristle_stiffness * z;
  const double stiffness = j.bristle_stiffness / level, side = rate > 0 ? 1 : -1;
  const double y = std::max(0.0, 1 - side * stiffness * z);
  z = side * (1 - y / (1 + y * stiffness * std::abs(rate) * h)) / stiffness;
  return j.bristle_stiffness * z;
}

/// No memory and no stiction: a joint under load creeps.
double arctangent(double rate, double level) {
  return level * 2 * std::numbers::inv_pi * std::atan(rate / kCreepSpeed);
}

}  // namespace

double friction_level(const JointTruth& j, double rate, double angle, double motor, double external,
                      double rest_s) {
  const double slow = std::abs(rate) / j.stribeck_speed;
  const double fall =
      j.formulas.fall == Fall::gaussian ? std::exp(-slow * slow) : 1 / (1 + slow * slow);
  double level = j.coulomb + j.stribeck * fall;
  level += j.load * std::abs(motor - external);
  level += std::abs(j.drive * motor - j.backdrive * external);
  level += j.quadratic * (motor - external) * (motor - external);
  level += j.ripple_sine * std::sin(j.ripple_order * angle) +
           j.ripple_cosine * std::cos(j.ripple_order * angle);
  level += (rate >= 0 ? 1 : -1) * j.coulomb_difference;
  if (rest_s > 0)
    level +=
        j.static_friction + (j.static_friction + j.coulomb) * j.dwell_rate * std::log1p(rest_s);
  return std::max(level, 1e-6);
}

double dry_friction(const JointTruth& j, double rate, double level, double h, double& z) {
  // what is hidden as presliding or as stiction needs a law that has it
  const bool needs_memory = j.bristle_stiffness < 1000 || j.static_friction > 0;
  if (j.formulas.friction == FrictionLaw::arctangent && !needs_memory)
    return arctangent(rate, level);
  return j.formulas.friction == FrictionLaw::lugre ? lugre(j, rate, level, h, z)
                                                   : dahl(j, rate, level, h, z);
}

}  // namespace sanso::conceal
