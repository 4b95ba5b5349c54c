// The robot that the planner believes in, as a model folder: what the trials of a session are
// compared with.
#pragma once

#include <string>

#include "shared/model/step_model.h"
#include "tools/diagnose/model_folder/whole_body.h"

namespace sanso::diagnose {

/// Links, joints, masses and soles; the base is `body_link`. Numbers to the last bit.
std::string planner_urdf(const model::ModelParameters& theta);

/// The same with drives (position_pd) and ground. On soles only.
WholeBody planner_body(const model::ModelParameters& theta);

}  // namespace sanso::diagnose
