// The upper factor is the lower one of the matrix turned by 180 degrees; a body that could not
// exist is an error.
#include "host/learn/model/pseudo_inertia.h"

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>

namespace sanso::learn {
namespace {

using Mat3 = Eigen::Matrix3d;
using Mat4 = Eigen::Matrix4d;
using Vec3 = Eigen::Vector3d;

Mat3 symmetric(const double* xx_xy_xz_yy_yz_zz) {
  const double* v = xx_xy_xz_yy_yz_zz;
  Mat3 I;
  I << v[0], v[1], v[2], v[1], v[3], v[4], v[2], v[4], v[5];
  return I;
}

Mat3 parallel_axis(double mass, const Vec3& c) {
  return mass * (c.squaredNorm() * Mat3::Identity() - c * c.transpose());
}

Mat4 pseudo_inertia(const model::BodyInertia& body) {
  const Vec3 com(body.com[0], body.com[1], body.com[2]);
  const Mat3 I_origin = symmetric(body.inertia) + parallel_axis(body.mass, com);
  Mat4 J;
  J.topLeftCorner<3, 3>() = 0.5 * I_origin.trace() * Mat3::Identity() - I_origin;
  J.topRightCorner<3, 1>() = body.mass * com;
  J.bottomLeftCorner<1, 3>() = body.mass * com.transpose();
  J(3, 3) = body.mass;
  return J;
}

// U upper triangular with J = U U': the lower Cholesky factor of J turned by 180 degrees, turned
// back.
Mat4 upper_factor(const Mat4& J) {
  const Eigen::LLT<Mat4> factor(J.reverse().eval());
  if (factor.info() != Eigen::Success) {
    throw std::invalid_argument(fmt::format(
        "body of mass {} kg: pseudo-inertia is not positive definite (its inertia breaks the "
        "triangle inequality, or its mass is not positive)",
        J(3, 3)));
  }
  const Mat4 lower = factor.matrixL();
  return lower.reverse();
}

}  // namespace

LogCholesky log_cholesky_of(const model::BodyInertia& body) {
  const Mat4 U = upper_factor(pseudo_inertia(body));
  const double scale = U(3, 3);  // e^alpha
  LogCholesky p;
  p << std::log(scale), std::log(U(0, 0) / scale), std::log(U(1, 1) / scale),
      std::log(U(2, 2) / scale), U(0, 1) / scale, U(1, 2) / scale, U(0, 2) / scale, U(0, 3) / scale,
      U(1, 3) / scale, U(2, 3) / scale;
  return p;
}

model::BodyInertia body_of(const LogCholesky& p) {
  Mat4 U;
  U << std::exp(p[1]), p[4], p[6], p[7], 0, std::exp(p[2]), p[5], p[8], 0, 0, std::exp(p[3]), p[9],
      0, 0, 0, 1;
  const Mat4 J = std::exp(2 * p[0]) * U * U.transpose();
  const double mass = J(3, 3);
  const Vec3 com = J.topRightCorner<3, 1>() / mass;
  const Mat3 Sigma = J.topLeftCorner<3, 3>();
  const Mat3 I = Sigma.trace() * Mat3::Identity() - Sigma - parallel_axis(mass, com);
  return {mass, {com[0], com[1], com[2]}, {I(0, 0), I(0, 1), I(0, 2), I(1, 1), I(1, 2), I(2, 2)}};
}

}  // namespace sanso::learn
