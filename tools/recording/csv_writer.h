// Writes a recording as CSV (gzip when the name ends in .gz) and its sidecar. What is written reads
// back bit for bit.
#pragma once

#include <string>

#include "tools/recording/recording.h"

namespace sanso::recording {

std::string to_csv(const Recording& recording);

/// Atomic: no half-written recording is ever seen. Throws files::WriteError. A sidecar is written
/// beside it when the recording has a condition, overrides or payloads.
void write_csv(const Recording& recording, const std::string& path);

}  // namespace sanso::recording
