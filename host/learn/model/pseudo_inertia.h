// A rigid body's ten inertial parameters as ten free numbers: the log-Cholesky factors of its
// pseudo-inertia. Every value of the ten gives a body that could exist (positive mass, a density
// that is nowhere negative).
//   J = [Sigma h; h' m] = U U',  Sigma = tr(I)/2 1 - I about the link origin,  h = m com
//   U = e^alpha [e^d1 s12 s13 t1; 0 e^d2 s23 t2; 0 0 e^d3 t3; 0 0 0 1]      [Rucker and Wensing
//   2022, eq. 14]
#pragma once

#include <Eigen/Core>

#include "shared/model/step_model.h"

namespace sanso::learn {

/// (10) [alpha d1 d2 d3 s12 s23 s13 t1 t2 t3]: alpha is half the log of the mass, t the centre of
/// mass [m].
using LogCholesky = Eigen::Matrix<double, 10, 1>;

/// Throws std::invalid_argument when the body's pseudo-inertia is not positive definite.
LogCholesky log_cholesky_of(const model::BodyInertia& body);
/// The inverse of log_cholesky_of; every value is a body that can be.
model::BodyInertia body_of(const LogCholesky& parameters);

}  // namespace sanso::learn
