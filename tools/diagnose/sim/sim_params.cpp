#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

SimParams make_params(const ModelFolder& model) {
  SimParams params;
  params.tree = model.tree;
  params.gravity = model.gravity;
  params.period_s = model.period_s;
  params.joints.resize(model.joints.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j) params.joints[j].nominal = model.joints[j];
  return params;
}

}  // namespace sanso::diagnose
