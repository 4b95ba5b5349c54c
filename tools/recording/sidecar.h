// The sidecar of a recording: FILE.toml beside FILE.csv, with what was set differently in that
// recording.
#pragma once

#include <string>
#include <string_view>

#include "tools/recording/recording.h"

namespace sanso::recording {

/// Adds condition, overrides and payloads to `recording`. Unknown keys are an error naming the key.
/// Throws InputError.
void read_sidecar(const std::string& path, Recording& recording);
/// The same for text in memory.
void parse_sidecar(std::string_view text, const std::string& name, Recording& recording);

void write_sidecar(const Recording& recording, const std::string& path);

}  // namespace sanso::recording
