// One scenario in virtual time: a robot of its own is put up, the motion is begun, trouble comes,
// and what happens is compared with what should.
#pragma once

#include "tools/campaign/witness.h"

namespace sanso::campaign {

/// Same scenario and seed, same result. Throws std::runtime_error when the robot cannot be put up.
Found run_scenario(const Scenario& scenario, std::uint64_t seed);

/// The same for a row of arming (Act::arm_early); called by run_scenario.
Found run_arming(const Scenario& scenario, std::uint64_t seed);

/// What is broken of `expected`, in words; empty when all holds. `trial_end`: why the trial ended,
/// empty when it was completed.
std::vector<std::string> broken_of(const Expected& expected, const Found& found,
                                   const std::string& trial_end);

}  // namespace sanso::campaign
