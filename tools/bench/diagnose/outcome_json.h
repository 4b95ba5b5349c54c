// Outcomes of cases as JSON and back: what a stopped run goes on with, and what scripts read.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/bench/diagnose/folder_bench.h"

namespace sanso::bench {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CaseJudgement, status, named, detected, named_first, in_set,
                                   place_right, refused, unnamed, right, wrong_confirmed, f1,
                                   set_size, relative_error, covered)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CaseOutcome, name, family, robot, ratio, seconds, truth, said,
                                   proved, explained, explained_bounded, oracle_explained)

}  // namespace sanso::bench
