// Rows between which a position is another without having gone there: the robot changed its hold,
// an encoder was set to zero, two logs stand in one file.
#pragma once

#include <cstddef>
#include <vector>

#include "tools/diagnose/gate/gate.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// Rows, ascending, from which on a position stays elsewhere though nothing moved as fast: neither
/// the joint around it, nor the recording at its fastest over a dropout of `jump_dropout`.
std::vector<std::size_t> position_jumps(const GateRecording& r,
                                        const std::vector<GateJoint>& joints,
                                        const GateSettings& settings);

/// The pieces of a recording between `rows`, each named after its file and place; shots never lead
/// across. Pieces too short for the gate are left out. No rows: the recording as it is.
std::vector<recording::Recording> cut_at(recording::Recording whole,
                                         const std::vector<std::size_t>& rows,
                                         const GateSettings& settings);

}  // namespace sanso::diagnose
