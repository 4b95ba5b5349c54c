// The chapters put together in the order of the method page, and what an effect can be asked.
#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::string_view to_string(Family family) {
  constexpr std::array<std::string_view, 8> names{
      "friction", "transmission", "mass", "electrical", "timing", "sensor", "contact", "external"};
  return names[static_cast<std::size_t>(family)];
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

std::vector<const Effect*> effort_effects(EffortKind kind) {
  std::vector<const Effect*> out;
  for (const Effect& effect : library()) {
    if (effect.effort.kind == kind) out.push_back(&effect);
  }
  std::sort(out.begin(), out.end(),
            [](const Effect* a, const Effect* b) { return a->effort.order < b->effort.order; });
  return out;
}

const Effect& effect_of(WholeFigure figure) {
  const std::vector<Effect>& all = library();
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const Effect& e) { return e.whole == figure; });
  if (figure == WholeFigure::none || at == all.end())
    throw std::logic_error("no effect is figure " + std::to_string(static_cast<int>(figure)));
  return *at;
}

const Effect* effect_of(JointFigure figure) {
  for (const Effect& effect : library()) {
    if (effect.drive && effect.drive->figure == figure) return &effect;
  }
  return nullptr;
}

std::string name_of(WholeFigure figure) { return std::string(effect_of(figure).id); }

bool Effect::fitted_by_identify(std::size_t k, Actuator actuator) const {
  if (k >= identified.size() || identified[k] == Identified::never) return false;
  return identified[k] == Identified::always || actuator == Actuator::torque;
}

bool Effect::fold_into(JointSettings& changed, std::size_t k, double value) const {
  if (k >= settings.size() || settings[k].keys.empty()) return false;
  const SettingChange& change = settings[k];
  if (change.only && *change.only != changed.actuator) return false;
  JointSettings out = changed;
  bool inside = true;
  JointSettings::visit(
      out, [&](std::string_view, double& setting, std::string_view, double low, double high) {
        for (const auto key : change.keys) {
          if (&(out.*key) != &setting) continue;
          setting = change.how == SettingChange::How::added ? setting + value : setting * value;
          inside = inside && low <= setting && setting <= high;
        }
      });
  if (inside) changed = out;
  return inside;
}

std::vector<Tolerated> tolerated_quantities() {
  std::vector<Tolerated> out;
  for (const Effect& e : library()) {
    for (const Tolerance& t : e.tolerances) out.push_back({&e, &t});
  }
  std::sort(out.begin(), out.end(), [](const Tolerated& a, const Tolerated& b) {
    return std::pair(a.tolerance->common, a.tolerance->order) <
           std::pair(b.tolerance->common, b.tolerance->order);
  });
  return out;
}

bool documented_twin(std::string_view name, std::string_view truth) {
  const Effect* named = find_effect(name);
  const Effect* there = find_effect(truth);
  if (named == nullptr || there == nullptr) return false;
  const auto lists = [](const std::vector<std::string_view>& ids, std::string_view id) {
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  return lists(there->confounders, name) || lists(named->contains, truth);
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
    case Unit::reach:
      return reach;
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
