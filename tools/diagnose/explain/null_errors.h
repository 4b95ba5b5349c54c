// Two null laws of an error that is not the scatter of any effect: it has nothing to do with the
// recording's time, or it is what readings alone make.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/explain/scatter_rows.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {

/// Errors against time, shifted: every recording's rows of a channel by the same number, around its
/// end. Colour and size stay.
Eigen::VectorXd shifted(const Comparison& comparison, const std::vector<Piece>& pieces,
                        const Eigen::VectorXd& x, Random& random);

/// Errors that the fitted model's own readings would have: noise, and the quantisation of the
/// predicted value. `r`: the model's error.
Eigen::VectorXd simulated_error(const Problem& problem, const Eigen::VectorXd& r, Random& random);

}  // namespace sanso::diagnose
