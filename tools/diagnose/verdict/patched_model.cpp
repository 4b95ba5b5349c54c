// Effects and calibrations of a search's model in the words of model.toml.
#include "tools/diagnose/verdict/patched_model.h"

#include <cmath>

#include "tools/diagnose/effects/from_model.h"

namespace sanso::diagnose {

ModelFolder patched_model(const ModelFolder& nominal, const Library& library, const Model& model) {
  ModelFolder out = nominal;
  const auto add = [&](const std::string& id, const std::vector<std::string>& where,
                       const std::vector<double>& theta) {
    out.effects.push_back(entry_of({find_effect(id), where, theta}));
  };
  for (std::size_t i = 0; i < model.nuisance.size(); ++i) {
    const Nuisance& n = library.nuisances[i];
    if (std::abs(model.nuisance[i]) < 0.01 * n.tolerance) continue;
    std::vector<std::string> where;
    for (const std::size_t j : n.joints) {
      const TreeJoint& joint = nominal.tree.joints[j];
      where.push_back(find_effect(n.effect)->scope == Scope::link ? joint.link : joint.name);
    }
    add(n.effect, where, n.theta(model.nuisance[i]));
  }
  for (const Chosen& c : model.effects) {
    const Candidate& candidate = library[c];
    add(candidate.effect, candidate.where, c.theta);
  }
  return out;
}

}  // namespace sanso::diagnose
