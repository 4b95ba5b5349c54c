// What these data could not show: effects that cannot be tested, and the smallest sizes that would
// have been seen.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/fit/screen.h"

namespace sanso::diagnose {

struct Untestable {
  std::string effect, because;
};

/// Smallest size that these data would have shown (80 % power at the family-wise level).
struct Detectable {
  std::string effect, where, parameter, unit;
  double size = 0.0;
};

/// Effects whose typical size these data could not show, and by probe the smallest size that they
/// would have shown: linear in the size of the probe.
std::vector<Untestable> too_quiet(const Library& library, const Screening& screening,
                                  const DecisionSettings& decisions);
/// Of each candidate's first probe; sizes beyond the parameter's own range are left out.
std::vector<Detectable> smallest_sizes(const Library& library, const Screening& screening);

}  // namespace sanso::diagnose
