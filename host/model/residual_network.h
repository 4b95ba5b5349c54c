// The residual network f_NN: two hidden layers of 64 softplus units on invariant features, one
// tangent out.
//
// Features (46), standardised:  [z_base 0 | gravity direction in base 1..3 | q 4..15 | v_base in
// base 16..18 |
//                                w_base_in_base 19..21 | dq 22..33 | u 34..45]
// Output (36), de-standardised: a tangent in the order of state_layout.h whose dp and dv are in
// base axes (of the state the step starts from); residual_tangent() turns them to world axes. So
// what is learned facing north holds facing east, and one metre further on.
#pragma once

#include <Eigen/Core>

#include "shared/model/state_layout.h"

namespace sanso::host {

inline constexpr int kFeatures = 34 + model::kNumJoints;
inline constexpr int kHidden = 64;

/// Weights of f_NN. Row-major, so that row i is what unit i sums over.
struct ResidualNetwork {
  template <int Rows, int Cols>
  using Weights = Eigen::Matrix<float, Rows, Cols, Eigen::RowMajor>;

  Eigen::Matrix<float, kFeatures, 1> feature_mean = Eigen::Matrix<float, kFeatures, 1>::Zero();
  // 1 / deviation
  Eigen::Matrix<float, kFeatures, 1> feature_scale = Eigen::Matrix<float, kFeatures, 1>::Ones();
  Weights<kHidden, kFeatures> W1 = Weights<kHidden, kFeatures>::Zero();
  Weights<kHidden, kHidden> W2 = Weights<kHidden, kHidden>::Zero();
  Weights<model::kNdx, kHidden> W3 = Weights<model::kNdx, kHidden>::Zero();
  Eigen::Matrix<float, kHidden, 1> b1 = Eigen::Matrix<float, kHidden, 1>::Zero();
  Eigen::Matrix<float, kHidden, 1> b2 = Eigen::Matrix<float, kHidden, 1>::Zero();
  Eigen::Matrix<float, model::kNdx, 1> b3 = Eigen::Matrix<float, model::kNdx, 1>::Zero();
  Eigen::Matrix<float, model::kNdx, 1> output_mean = Eigen::Matrix<float, model::kNdx, 1>::Zero();
  // deviation
  Eigen::Matrix<float, model::kNdx, 1> output_scale = Eigen::Matrix<float, model::kNdx, 1>::Ones();
};

using Features = Eigen::Matrix<double, kFeatures, 1>;

/// The inputs of the network for one state and input, not yet standardised.
Features residual_features(const model::State& x, const model::Input& u);

/// Output in base axes, double precision throughout: the reference for the lanes and for training.
model::Tangent residual_output(const ResidualNetwork& network, const Features& features);

/// f_NN(x, u) as a tangent to be added to the analytical step's result: x' = f_A(x, u) ⊕ f_NN(x,
/// u).
model::Tangent residual_tangent(const ResidualNetwork& network, const model::State& x,
                                const model::Input& u);

/// The training target: the output in base axes that would have led from x to `next_measured`.
model::Tangent residual_target(const model::State& x, const model::State& next_analytical,
                               const model::State& next_measured);

}  // namespace sanso::host
