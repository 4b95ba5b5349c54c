// The options of a page and what stands behind its buttons: `sanso demo`, `learn` and `watch` share
// them.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "host/app/learn_command.h"
#include "tools/page/live_page.h"

namespace sanso::cli {

struct PageOptions {
  int port = -1;  // negative: no page; 0: any port
  bool control = false;
  bool open = false;
  std::string urdf;  // file that says what the robot looks like; empty: as the emulated robot
};

void add_page_options(CLI::App& command, PageOptions& options);

/// Serves the page and prints its address; null when it is not wanted or was not built. `ground`:
/// of the robot's world instead of the world's own, as for `sanso learn`.
std::unique_ptr<page::LivePage> serve_page(const PageOptions& options, const std::string& robot,
                                           const std::string& world,
                                           const std::string& ground = "plane");

/// The robot with the page beside it: watched over a session of its own, or in process as it is
/// made. `page` may be null.
using MakeRobot = std::function<std::unique_ptr<learn::RobotAccess>(const app::LearnOptions&)>;
MakeRobot watched(page::LivePage* page);

/// Learns, with the page; then what a person asks for on it, motion by motion, each in a folder
/// beside the first. Exit code of the last.
int learn_with_page(app::LearnOptions options, page::LivePage* page, const PageOptions& asked,
                    const std::function<void(const app::LearnOptions&)>& after);

}  // namespace sanso::cli
