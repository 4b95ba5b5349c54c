// [[effect]] entries to effects at joints or links, with every name checked against library and
// tree.
#include "tools/diagnose/effects/from_model.h"

#include <algorithm>

#include "shared/files/input_error.h"

namespace sanso::diagnose {

int place_of(const Effect& effect, const RobotTree& tree, const std::string& name) {
  if (effect.scope == Scope::joint) {
    const int j = tree.index_of(name);
    return j >= 0 ? j : -2;
  }
  const auto link = tree.links.find(name);
  return link == tree.links.end() ? -2 : link->second.joint;
}

void apply(const EffectInstance& instance, SimParams& params) {
  // effects of the ground: nothing to simulate on a fixed base
  if (!instance.effect->apply) return;
  if (instance.effect->scope == Scope::robot) {
    instance.effect->apply(params, -1, instance.theta);
    return;
  }
  for (const std::string& name : instance.where) {
    const int j = place_of(*instance.effect, params.tree, name);
    if (j >= 0) instance.effect->apply(params, j, instance.theta);
  }
}

std::vector<EffectInstance> instances_of(const ModelFolder& model) {
  std::vector<EffectInstance> instances;
  const std::string file = model.folder.empty() ? "model.toml" : model.folder + "/model.toml";
  for (const EffectEntry& entry : model.effects) {
    const auto fail = [&](const std::string& key, const char* defect, const std::string& value,
                          const std::string& expected) {
      throw files::InputError(file, entry.line, "effect." + key, defect, value, expected);
    };
    const Effect* effect = find_effect(entry.id);
    if (effect == nullptr)
      fail("id", "unknown effect", entry.id, "an id of the table in docs/model-folder.md");
    if (!effect->apply)
      fail("id", "effect not simulated on a fixed base", entry.id,
           "an effect without ground or IMU");
    EffectInstance instance{effect, entry.where, effect->null()};
    if ((effect->scope == Scope::robot) != entry.where.empty()) {
      fail("where", "wrong place", std::to_string(entry.where.size()) + " names",
           effect->scope == Scope::robot ? "no `where`: the effect is the whole robot's"
                                         : "at least one " + std::string(to_string(effect->scope)));
    }
    for (const std::string& name : entry.where) {
      if (place_of(*effect, model.tree, name) < 0) {
        fail("where", "unknown place", name,
             "a moving " + std::string(to_string(effect->scope)) + " of the URDF");
      }
    }
    for (const auto& [name, value] : entry.parameters) {
      const auto p =
          std::find_if(effect->parameters.begin(), effect->parameters.end(),
                       [&name = name](const EffectParameter& q) { return q.name == name; });
      if (p == effect->parameters.end())
        fail(name, "unknown parameter", name,
             "a parameter of " + entry.id + " (docs/model-folder.md)");
      instance.theta[static_cast<std::size_t>(p - effect->parameters.begin())] = value;
    }
    instances.push_back(std::move(instance));
  }
  return instances;
}

EffectEntry entry_of(const EffectInstance& instance) {
  EffectEntry entry{std::string(instance.effect->id), instance.where, {}, 0};
  for (std::size_t k = 0; k < instance.theta.size(); ++k)
    entry.parameters[std::string(instance.effect->parameters[k].name)] = instance.theta[k];
  return entry;
}

SimParams params_with_effects(const ModelFolder& model, const SimulationSettings& settings) {
  SimParams params = make_params(model, settings);
  for (const EffectInstance& instance : instances_of(model)) apply(instance, params);
  return params;
}

}  // namespace sanso::diagnose
