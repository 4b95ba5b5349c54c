// One identification of the model's parameters whose candidates are spread over ranks.
#pragma once

#include "host/app/identify_command.h"
#include "tools/sweep/ranks.h"

namespace sanso::sweep {

/// Every rank gets the same answer, bit for bit the one of a single rank; rank 0 stores. SIGINT or
/// SIGTERM at any rank ends the search after the generation under way (Identification::generations
/// says how many there were).
learn::Identification identify_over(const Ranks& ranks, const app::IdentifyOptions& options,
                                    const app::IdentificationData& data);

/// Prints the answer at rank 0. Exit code: 0 found, 2 stopped before the last generation.
int run_identification(const Ranks& ranks, const app::IdentifyOptions& options);

}  // namespace sanso::sweep
