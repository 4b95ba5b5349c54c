// Effects as model.toml writes them, and back.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/model_folder/model_folder.h"

namespace sanso::diagnose {

/// An effect of the library at a place, with values. Several joints in `where` share the values.
struct EffectInstance {
  const Effect* effect = nullptr;
  std::vector<std::string> where;  // joints or links; empty for effects of the whole robot
  std::vector<double> theta;       // in the order of effect->parameters
};

/// Changes `params`. Names must be known (instances_of checks them).
void apply(const EffectInstance& instance, SimParams& params);

/// The [[effect]] entries of a model, checked: id, places, parameter names, bounds-free. Parameters
/// not written keep their null. Throws files::InputError.
std::vector<EffectInstance> instances_of(const ModelFolder& model);

/// What model.toml will hold for an instance.
EffectEntry entry_of(const EffectInstance& instance);

/// make_params and every [[effect]] of the model: what a model folder means.
SimParams params_with_effects(const ModelFolder& model, const SimulationSettings& settings = {});

/// Index of the joint that a joint's or link's name stands for; -1 for the base, -2 when there is
/// none.
int place_of(const Effect& effect, const RobotTree& tree, const std::string& name);

}  // namespace sanso::diagnose
