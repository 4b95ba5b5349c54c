// From evidence to a verdict.
#pragma once

#include "tools/diagnose/verdict/evidence.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

/// Status, answer in one sentence, and all that verdict.json says. REFUSED where there are defects;
/// UNFINISHED where the run was ended;
/// PRESENT_UNNAMED where something stays without a name; ABSENT without a finding; ONE_OF where
/// these data cannot tell some names apart; else CONFIRMED.
Verdict conclude(const Evidence& all);

}  // namespace sanso::diagnose
