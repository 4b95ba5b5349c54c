#include <array>
#include <utility>

#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::string_view to_string(Family family) {
  constexpr std::array<std::string_view, 8> names{
      "friction", "transmission", "mass", "electrical", "timing", "sensor", "contact", "external"};
  return names[static_cast<std::size_t>(family)];
}
std::string_view to_string(Port port) {
  constexpr std::array<std::string_view, 9> names{"clock",      "command path", "firmware",
                                                  "electrical", "transmission", "rigid body",
                                                  "contact",    "external",     "sensor"};
  return names[static_cast<std::size_t>(port)];
}
std::string_view to_string(Scope scope) {
  constexpr std::array<std::string_view, 3> names{"joint", "link", "robot"};
  return names[static_cast<std::size_t>(scope)];
}

std::vector<double> Effect::null() const {
  std::vector<double> theta;
  for (const EffectParameter& p : parameters) theta.push_back(p.null);
  return theta;
}

const std::vector<Effect>& library() {
  static const std::vector<Effect> all = [] {
    std::vector<Effect> effects;
    for (auto chapter : {friction_effects, transmission_effects, mass_effects, electrical_effects,
                         timing_effects, sensor_effects, contact_effects, external_effects}) {
      for (Effect& effect : chapter()) effects.push_back(std::move(effect));
    }
    return effects;
  }();
  return all;
}

const Effect* find_effect(std::string_view id) {
  for (const Effect& effect : library()) {
    if (effect.id == id) return &effect;
  }
  return nullptr;
}

double JointScale::of(Unit unit) const {
  switch (unit) {
    case Unit::none:
      return 1.0;
    case Unit::torque:
      return torque;
    case Unit::speed:
      return speed;
    case Unit::acceleration:
      return torque / inertia;
    case Unit::viscous:
      return torque / speed;
    case Unit::drag:
      return torque / (speed * speed);
    case Unit::inertia:
      return inertia;
    case Unit::angle:
      return angle;
    case Unit::stiffness:
      return torque / angle;
    case Unit::compliance:
      return angle / torque;
    case Unit::per_torque:
      return 1.0 / torque;
    case Unit::per_angle:
      return 1.0 / angle;
    case Unit::current:
      return current;
    case Unit::length:
      return length;
    case Unit::force:
      return torque / length;
  }
  return 1.0;
}

namespace {
double scaled_value(double value, double factor) { return value == kOff ? kOff : value * factor; }
}  // namespace

EffectParameter scaled(const EffectParameter& parameter, const JointScale& scale) {
  EffectParameter p = parameter;
  const double factor = scale.of(p.scale);
  for (double* value : {&p.null, &p.low, &p.high, &p.typical})
    *value = scaled_value(*value, factor);
  return p;
}

std::vector<std::vector<double>> scaled_probes(const Effect& effect, const JointScale& scale) {
  std::vector<std::vector<double>> probes = effect.probes;
  for (std::vector<double>& theta : probes) {
    for (std::size_t k = 0; k < theta.size(); ++k)
      theta[k] = scaled_value(theta[k], scale.of(effect.parameters[k].scale));
  }
  return probes;
}

}  // namespace sanso::diagnose
