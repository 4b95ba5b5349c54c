// An effect tied over joints, and a second term of its kind at some of them: together they are a
// number for each joint.
#pragma once

#include <optional>
#include <vector>

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// A model that has the tied effect at each of its joints alone instead.
struct Untied {
  // the effects that stay, in their order, then one for each joint
  Model model;
  std::vector<std::size_t> replaced;  // of the tied model's effects, ascending
  std::vector<std::size_t> stay;      // the others, ascending
};

/// One, of no more than `most` effects, for every effect of `model` over several joints
/// beside which the same effect, or a documented twin of it, stands at some of these joints. Each
/// joint begins at the tied parameters.
std::vector<Untied> untied(const Library& library, const Model& model, std::size_t most);

/// Its fit, when it explains the groups seen and predicts groups left out as well as `tied` does:
/// within one standard error or a difference that does not matter. For the second, both are fitted
/// again without each group.
std::optional<FitResult> fit_untied(const Surroundings& around, const Untied& apart,
                                    const FitResult& tied);

}  // namespace sanso::diagnose
