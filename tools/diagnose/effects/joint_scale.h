// How large torques, speeds and inertias of this robot's joints are, so that the library's bounds
// fit any of them.
#pragma once

#include <span>
#include <vector>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/settings_of_simulation.h"
#include "tools/diagnose/sim/drive.h"

namespace sanso::diagnose {

/// One a joint. From the model's motor or limits where it states them, else from what the
/// recordings show.
std::vector<JointScale> joint_scales(const SimParams& params, std::span<const Drive> drives,
                                     const LibrarySettings& library = {});

/// Why an effect cannot be tested at joint `where` (-1: robot) with these recordings; empty when it
/// can.
std::string why_untestable(const Effect& effect, const SimParams& params,
                           std::span<const Drive> drives, int where);

}  // namespace sanso::diagnose
