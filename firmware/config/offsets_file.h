// The offsets file that every OP3 has (offset.yaml of the maker's tuner): rad per joint, by which
// the horns of the servos are put on crookedly. Not real-time.
#pragma once

#include <string>

#include "firmware/config/settings.h"

namespace sanso::firmware {

/// Reads `path` into `offset_rad`, index = servo id - 1; joints that are not in it keep 0. False:
/// `error` says file, line, value and what was expected.
bool read_offsets_file(const std::string& path, JointOffsets& offset_rad, std::string& error);
/// The same from text; `name` stands for the file in messages.
bool parse_offsets(const std::string& text, const std::string& name, JointOffsets& offset_rad,
                   std::string& error);

}  // namespace sanso::firmware
