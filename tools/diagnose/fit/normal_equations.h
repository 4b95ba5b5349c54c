// What the normal equations of a fit and those of its parts left out have in common:
// (J' M J + prior) delta = J' M r.
#pragma once

#include <Eigen/Core>

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// Prior precision of what has none: keeps the matrix regular where a number moves nothing.
inline constexpr double kWhisper = 1e-6;

/// Prior precision: nothing on effects (beyond a whisper), the tolerance on nuisances.
inline double prior(const Surroundings& around, Eigen::Index effects, Eigen::Index i) {
  return i < effects ? kWhisper : around.settings().tolerances.precision;
}

/// [J r]: the error as one more column, so that one Gram matrix holds both sides.
inline Eigen::MatrixXd with_error(const Eigen::MatrixXd& J, const Eigen::VectorXd& r) {
  Eigen::MatrixXd all(J.rows(), J.cols() + 1);
  all << J, r;
  return all;
}

}  // namespace sanso::diagnose
