// Recordings of a small world compared with a model: what the tests of search, explanation and
// verdict start from.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/small_world.h"
#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose::test {

/// The shots of `recordings` under `nominal`, the library's `effects` (ids; empty: all) placed on
/// them, and the nuisances.
struct SmallComparison {
  Problem problem;
  Library library;

  SmallComparison(const ModelFolder& nominal, const std::vector<recording::Recording>& recordings,
                  const std::vector<NoiseLevel>& noise, const std::vector<std::string>& effects)
      : problem(make_problem(make_sources(nominal, recordings, noise, Settings{}), noise,
                             ProblemOptions{}, Settings{})) {
    library.candidates = place_library(*problem, effects).candidates;
    library.nuisances = make_nuisances(*problem);
  }

  /// The first candidate that is this effect, or the one at exactly these joints. Throws where the
  /// library has none.
  std::size_t of(const std::string& effect, const std::vector<std::size_t>& joints = {}) const {
    for (std::size_t i = 0; i < library.candidates.size(); ++i) {
      const Candidate& c = library.candidates[i];
      if (c.effect == effect && (joints.empty() || c.joints == joints)) return i;
    }
    throw std::out_of_range(effect + " is not in the library");
  }
  std::vector<std::size_t> all() const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < library.candidates.size(); ++i) out.push_back(i);
    return out;
  }
  const std::string& name_of(std::size_t candidate) const { return library[candidate].effect; }
};

}  // namespace sanso::diagnose::test
