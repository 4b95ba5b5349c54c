// Which feet are in the air where nobody recorded their forces: attitude and joints tell it.
#pragma once

#include <vector>

#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

/// By row: joints of the links that may touch and are surely above what the lowest of them stands
/// on. Empty where the recording has no attitude, or forces say it.
std::vector<std::vector<int>> lifted_feet(const Asking& asking, const WholeRecording& recording);

}  // namespace sanso::diagnose
