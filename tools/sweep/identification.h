// One identification of the model's parameters whose candidates are spread over ranks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/sweep/ranks.h"

namespace sanso::sweep {

struct IdentificationOptions {
  std::filesystem::path session;  // folder of episodes
  std::string motion = "squat";   // whose weights the loss uses
  std::uint64_t seed = 1;
  int population = 64, generations = 15;
};

/// Every rank gets the same answer, bit for bit the one of a single rank. SIGINT or SIGTERM at any rank ends the search
/// after the generation under way (Identification::generations says how many there were).
learn::Identification identify_over(const Ranks& ranks, const IdentificationOptions& options);

/// Prints the answer at rank 0. Exit code: 0 found, 2 stopped before the last generation.
int run_identification(const Ranks& ranks, const IdentificationOptions& options);

}  // namespace sanso::sweep
