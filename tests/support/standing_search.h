// A search that has accepted names already, whatever they explain: where steps that take names away
// or exchange them begin.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/explain/steps.h"

namespace sanso::diagnose::test {

using Names = std::vector<std::string>;

inline const std::vector<std::string> kTried{"coulomb_friction", "viscous_friction",
                                             "cable_spring"};
inline const EffectEntry kRubbing = hidden("coulomb_friction", "a", {{"coulomb", 0.08}});
inline const EffectEntry kSpring =
    hidden("cable_spring", "a", {{"stiffness", 0.3}, {"torque", 0.0}});

/// A search that has accepted some names already, whatever they explain.
struct Standing {
  Standing(const std::vector<EffectEntry>& world, const std::vector<std::string>& names,
           const std::vector<std::string>& tried = kTried)
      : c(compared(pendulum(kNoisyServo), world, tried, 41, 3)),
        state(c.problem, c.library, options) {
    Selection& found = state.found;
    found.around = make_surroundings(state.problem, c.library, nominal(c));
    const FitResult clean = fit(*found.around, nominal(c), 3);
    found.first = screen(*found.around, clean.model, clean.r, c.all(), Random(1));
    found.nominal = clean;
    found.final.model = nominal(c);
    for (const std::string& name : names) {
      Accepted entry;
      entry.candidate = c.of(name);
      found.accepted.push_back(entry);
      std::vector<double> theta;
      for (const CandidateParameter& p : c.library[c.of(name)].parameters)
        theta.push_back(p.null + 0.3 * p.typical);
      found.final.model.effects.push_back({c.of(name), theta});
    }
    state.relinearise();
    state.found.final = fit(*found.around, found.final.model, 10);
    state.relinearise();
  }
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (std::size_t i = 0; i < state.found.accepted.size(); ++i) {
      out.push_back(state.accepted(i).effect);
      // what the state promises (search_state.h)
      EXPECT_EQ(state.found.final.model.effects[i].candidate, state.found.accepted[i].candidate);
    }
    EXPECT_EQ(out.size(), state.found.final.model.effects.size());
    return out;
  }
  bool said(const std::string& text) const {
    for (const std::string& line : state.found.log)
      if (line.find(text) != std::string::npos) return true;
    return false;
  }
  SmallComparison c;
  SelectOptions options;
  SearchState state;
};

}  // namespace sanso::diagnose::test
