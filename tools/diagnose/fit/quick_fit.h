// A fit that is only compared by what it leaves: no derivatives where it ends.
#pragma once

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

struct QuickFit {
  Model model;
  double objective = 0.0;
  Eigen::VectorXd r;  // prediction error at the model
};

/// Model, objective and error that fit() gives, without the passes that its derivatives take: a
/// third to a half of a short fit.
QuickFit quick_fit(const Surroundings& around, const Model& start, int iterations);

}  // namespace sanso::diagnose
