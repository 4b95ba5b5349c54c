// Copies the model folder's figures; every field that only an effect changes keeps its null.
#include "tools/diagnose/sim/sim_params.h"

#include <limits>

namespace sanso::diagnose {

SimParams make_params(const ModelFolder& model, const SimulationSettings& settings) {
  SimParams params;
  params.settings = settings;
  params.tree = model.tree;
  params.gravity = model.gravity;
  params.period_s = model.period_s;
  params.joints.resize(model.joints.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    params.joints[j].nominal = model.joints[j];
    if (j < model.stated_gain.size()) params.joints[j].stated_gain = model.stated_gain[j];
    if (j < model.stated_voltage.size()) params.joints[j].stated_voltage = model.stated_voltage[j];
  }
  // a link's own mass stays apart from what was put on it, so that an effect on the link leaves the
  // weight alone
  for (const AttachedBody& p : model.payloads)
    params.late_payloads.push_back({p.joint, p.body, -std::numeric_limits<double>::infinity()});
  return params;
}

}  // namespace sanso::diagnose
