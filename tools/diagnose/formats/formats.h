// A model folder with its effects in the formats of other simulators: MuJoCo's MJCF, URDF, SDF.
// What a format cannot hold is left out and said, in the file too.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/model_folder/model_folder.h"

namespace sanso::diagnose {

struct Exported {
  std::string text;
  std::vector<std::string> lost;  // one sentence each; empty: the model is whole
};

/// Bodies, joints with rotor inertia, friction and springs, and the actuators: predicts as ours
/// what is not in `lost`.
Exported mjcf_of(const ModelFolder& model);
/// Bodies, joints, friction. The shapes of the model's own URDF are kept in all formats.
Exported urdf_of(const ModelFolder& model);
Exported sdf_of(const ModelFolder& model);
// All throw files::InputError where the model is no fixed base or names an effect that is none.

}  // namespace sanso::diagnose
