// The report of a learning session: report.html from the folder that `sanso learn` or `sanso demo`
// wrote.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/session_report/replay.h"

namespace sanso::report {

/// Writes `folder`/report.html and returns its path. Throws std::runtime_error when the folder
/// holds no finished trial.
std::filesystem::path write_session_report(const std::filesystem::path& folder);

/// film_page() of a session's folder.
std::string film_page_of(const std::filesystem::path& folder, const FilmOptions& options);

/// The table a terminal shows: one line a trial (cost, failed, policy updates, late updates, bus
/// errors).
std::string session_table(const std::filesystem::path& folder);

/// Cost over trials of several sessions in one figure, each named after its folder, as SVG.
std::string compare_costs(const std::vector<std::filesystem::path>& folders);

/// Writes the session's figures over trials as SVG files: cost, layers, gains, update times.
void write_session_figures(const std::filesystem::path& folder, const std::filesystem::path& to);

}  // namespace sanso::report
