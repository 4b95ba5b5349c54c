// Rows that a recorder wrote again because nothing new was read: a cycle of the bus that was lost.
#pragma once

#include <vector>

#include "tools/diagnose/gate/gate.h"

namespace sanso::diagnose {

/// By row, not 0: every reading that is sampled there repeats the row before, though the motion
/// went on. Empty: the recording has no such rows.
std::vector<char> stale_rows(const GateRecording& r, const GateSettings& settings);

}  // namespace sanso::diagnose
