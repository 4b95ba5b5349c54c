// An effect asked to predict what another one predicts. Where dry friction sticks and slips, fits
// to the data end in one of many hollows, and of two names for the same motion one seems better by
// accident. Another model's prediction has neither noise nor causes of its own: whoever can say the
// same is found there.
#pragma once

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

struct Imitation {
  Model model;            // the goal's, with the other effect last, in the place of the goal's
  double distance = 0.0;  // sum over shots of rho(d' M d), d the difference of the predictions
};

/// The model of `goal` with `other` in the place of its `place`-th effect, moved to where its
/// prediction comes closest to the goal's. Everything else stays; `other.theta`: where to begin,
/// beside sizes of the library.
Imitation imitate(const Surroundings& around, const FitResult& goal, std::size_t place,
                  const Chosen& other);

}  // namespace sanso::diagnose
