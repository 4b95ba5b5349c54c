// Films and pictures of a session, drawn without a display by a browser that nobody sees: the same
// page draws them that shows the robot.
#pragma once

#include <filesystem>

#include "tools/session_report/session_report.h"

namespace sanso::cli {

/// "png", "gif" or "webm" from the end of the file's name. Throws std::runtime_error on another.
std::string film_kind(const std::filesystem::path& out);

/// Throws std::runtime_error when there is no browser or it does not draw.
void make_film(const std::filesystem::path& folder, const report::FilmOptions& options,
               const std::filesystem::path& browser, const std::filesystem::path& out);

}  // namespace sanso::cli
