// A model that a search ended with, as a model folder.
#pragma once

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/model_folder/model_folder.h"

namespace sanso::diagnose {

/// The model's effects and calibrations as entries of model.toml, behind those of `nominal`.
/// Calibrations of less than a hundredth of their tolerance are left out.
ModelFolder patched_model(const ModelFolder& nominal, const Library& library, const Model& model);

}  // namespace sanso::diagnose
