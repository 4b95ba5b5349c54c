// Every combination of motions, worlds and seeds as a learning session of its own, spread over
// ranks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/app/learn_command.h"
#include "tools/sweep/ranks.h"

namespace sanso::sweep {

struct SessionsOptions {
  std::vector<std::string> motions{"stand", "squat"}, worlds{"lab"};
  std::vector<std::uint64_t> seeds{1};
  std::vector<std::string> without;
  int iterations = 10, threads = 1;
  std::filesystem::path out;  // one folder a session, and sweep.json
};

/// The sessions in the order of their numbers.
std::vector<app::LearnOptions> sessions_of(const SessionsOptions& options);

/// Runs what is not finished yet; rank 0 writes sweep.json. Exit code: 0 every session is finished;
/// 2 one gave no answer, or SIGINT or SIGTERM came: the trials under way end and are stored, no
/// session begins after that, and the same call goes on.
int run_sessions(Ranks& ranks, const SessionsOptions& options, const app::RobotFactory& make_robot);

}  // namespace sanso::sweep
