// Rows of two links with written efforts, and what the torque side names in them.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "tests/tools/diagnose/torque/written_effort.h"
#include "tools/diagnose/torque/judge.h"

namespace sanso::diagnose::test {

inline constexpr const char* kTorque =
    "actuator = \"torque\"\ntorque_limit = 0.0\nviscous = 0.05\n";

using Names = std::vector<std::string>;

inline EffortRows two_link_rows(const Missing& missing, double noise = kNoise,
                                std::uint64_t seed = 1) {
  return rows_of({recorded(test::two_links(kTorque), "one.csv", 20.0, sines)}, missing, noise,
                 seed);
}

inline double nothing(const MotionSample&, int, double) { return 0.0; }
/// 0.2 N m of friction at joint a.
inline double friction_at_a(const MotionSample& m, int j, double) {
  return j == 0 ? 0.2 * sign(m.dq[0]) : 0.0;
}

inline EffortOutcome explained(const EffortRows& rows, const Names& effects = {}) {
  ChooseOptions options;
  options.effects = effects;
  return explain_effort(rows, Settings{}, options);
}

inline Names named(const EffortOutcome& outcome) {
  Names out;
  for (const JudgedTerm& t : outcome.terms) {
    if (t.predicts) out.push_back(in_words(t.term));
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace sanso::diagnose::test
