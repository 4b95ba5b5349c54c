// What a sidecar says, applied to a model.
#include "shared/files/input_error.h"
#include "tools/diagnose/model_folder/model_folder.h"

namespace sanso::diagnose {
namespace {

using files::InputError;
using recording::Override;

void set(JointSettings& settings, const Override& o) {
  if (o.key == "actuator") {
    // checked by the reader
    settings.actuator = recording::actuator_from(o.text).value_or(settings.actuator);
    return;
  }
  JointSettings::visit(settings,
                       [&](std::string_view key, double& value, std::string_view, double, double) {
                         if (key == o.key) value = o.numbers.at(0);
                       });
}

void apply(const Override& o, const std::string& file, ModelFolder& model) {
  if (o.table == "robot") {
    model.gravity = {o.numbers.at(0), o.numbers.at(1), o.numbers.at(2)};
  } else if (o.table == "control") {
    model.period_s = o.numbers.at(0);
  } else if (o.table == "joint_default") {
    set(model.joint_default, o);
    for (JointSettings& joint : model.joints) set(joint, o);
  } else {
    const std::string name = o.table.substr(o.table.find('.') + 1);
    const int index = model.tree.index_of(name);
    if (index < 0)
      throw InputError(file, o.line, o.table, "unknown joint", name, "a joint of the model's URDF");
    set(model.joints[static_cast<std::size_t>(index)], o);
  }
}

void attach(const recording::Payload& payload, const std::string& file, ModelFolder& model) {
  const auto place = model.tree.links.find(payload.link);
  if (place == model.tree.links.end()) {
    throw InputError(file, 0, "payload.link", "unknown link", payload.link,
                     "a link of the model's URDF");
  }
  if (place->second.joint < 0) return;  // on the fixed base it changes nothing
  const BodyInertia point{payload.mass, payload.com, {}};
  model.payloads.push_back(
      {place->second.joint, moved(point, place->second.R_joint_link, place->second.p_joint_link)});
}

}  // namespace

ModelFolder with_overrides(const ModelFolder& model, const recording::Recording& recording) {
  ModelFolder changed = model;
  changed.stated_gain.clear(), changed.stated_voltage.clear();
  for (const JointSettings& joint : model.joints) {
    changed.stated_gain.push_back(recording::loop_gain(joint));
    changed.stated_voltage.push_back(joint.voltage);
  }
  const std::string sidecar = recording.stem() + ".toml";
  // first what holds for every joint, then what names one: the order of the tables in a file does
  // not matter
  for (const Override& o : recording.overrides) {
    if (!o.table.starts_with("joint.")) apply(o, sidecar, changed);
  }
  for (const Override& o : recording.overrides) {
    if (o.table.starts_with("joint.")) apply(o, sidecar, changed);
  }
  for (const recording::Payload& payload : recording.payloads) attach(payload, sidecar, changed);
  return changed;
}

}  // namespace sanso::diagnose
