// Features and forward pass in double precision: the reference for the lanes of host/mpc.
#include "host/model/residual_network.h"

#include <cmath>

#include "host/model/softplus.h"

namespace sanso::host {
namespace {

using model::kNumJoints;
using Hidden = Eigen::Matrix<double, kHidden, 1>;

// Turns the linear blocks of a tangent with R; the other blocks are already in body or joint
// coordinates.
model::Tangent with_linear_blocks_turned(const math::Mat3& R, model::Tangent d) {
  d.segment<3>(model::kDPos) = (R * d.segment<3>(model::kDPos)).eval();
  d.segment<3>(model::kDVel) = (R * d.segment<3>(model::kDVel)).eval();
  return d;
}

}  // namespace

Features residual_features(const model::State& x, const model::Input& u) {
  const math::Mat3 R_world_base = math::rotation_matrix(model::base_quat(x));
  Features f;
  f[0] = x[model::kXPos + 2];
  // unit vector of gravity, world (0, 0, -1), in base axes
  f.segment<3>(1) = -R_world_base.row(2).transpose();
  f.segment<kNumJoints>(4) = model::joints(x);
  f.segment<3>(16) = R_world_base.transpose() * x.segment<3>(model::kXVel);
  f.segment<3>(19) = x.segment<3>(model::kXOmega);
  f.segment<kNumJoints>(22) = model::joint_rates(x);
  f.segment<kNumJoints>(34) = u;
  return f;
}

model::Tangent residual_output(const ResidualNetwork& n, const Features& features) {
  const Features z =
      (features - n.feature_mean.cast<double>()).cwiseProduct(n.feature_scale.cast<double>());
  const Hidden a1 = n.W1.cast<double>() * z + n.b1.cast<double>();
  const Hidden h1 = a1.unaryExpr(&softplus<double>);
  const Hidden a2 = n.W2.cast<double>() * h1 + n.b2.cast<double>();
  const Hidden h2 = a2.unaryExpr(&softplus<double>);
  const model::Tangent y = n.W3.cast<double>() * h2 + n.b3.cast<double>();
  return n.output_mean.cast<double>() + y.cwiseProduct(n.output_scale.cast<double>());
}

model::Tangent residual_tangent(const ResidualNetwork& n, const model::State& x,
                                const model::Input& u) {
  return with_linear_blocks_turned(math::rotation_matrix(model::base_quat(x)),
                                   residual_output(n, residual_features(x, u)));
}

model::Tangent residual_target(const model::State& x, const model::State& next_analytical,
                               const model::State& next_measured) {
  return with_linear_blocks_turned(math::rotation_matrix(model::base_quat(x)).transpose(),
                                   model::minus(next_measured, next_analytical));
}

}  // namespace sanso::host
