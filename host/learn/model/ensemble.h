// What the data leave open: parameters refined on windows drawn anew, whose models differ where
// nothing in the windows decides (bootstrap over blocks of windows).
#pragma once

#include <cstdint>

#include "host/learn/model/refine.h"

namespace sanso::learn {

struct EnsembleSettings {
  int members = 0;
  int steps = 2;

  constexpr void visit(auto&& field) {
    field("members", members, "models", 0, 8,
          "beside the one in use, each refined on windows drawn with replacement; what they differ "
          "by is the noise of mpc.spread. 0: none");
    field("member_steps", steps, "steps", 1, 100, "of Gauss-Newton for each, from the one in use");
  }
};

/// Parameters of the members, from `z` on. `problem`, `prior`, `threads`: as for refined(). One
/// seed, one result.
std::vector<Eigen::VectorXd> ensemble(const RefineProblem& problem, double prior,
                                      const Eigen::VectorXd& z, const EnsembleSettings& settings,
                                      std::uint64_t seed, int threads);

}  // namespace sanso::learn
