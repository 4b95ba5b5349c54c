// Least squares with a bound on every unknown, from the normal equations.
#pragma once

#include <Eigen/Core>

namespace sanso::diagnose {

/// x that minimises x'Gx / 2 - c'x with low <= x <= high (infinite: no bound); G (n x n) symmetric,
/// positive semidefinite. Exact up to rounding, by active sets (Stark and Parker 1995). An unknown
/// that nothing determines becomes the value nearest to zero within its bounds.
Eigen::VectorXd bounded_least_squares(const Eigen::MatrixXd& G, const Eigen::VectorXd& c,
                                      const Eigen::VectorXd& low, const Eigen::VectorXd& high);

}  // namespace sanso::diagnose
