// The cost of a state and of the upper layer's contribution: l = ||x ⊖ x_ref||²_Wx + ||u_up||²_Wu
// (paper, eq. 19).
// No factor 1/2; both weights diagonal; the last knot has the same state weights. The sum over a
// trial is what J_th limits.
#pragma once

#include "shared/model/state_layout.h"

namespace sanso::mpc {

/// Diagonal weights, one set per motion.
struct CostWeights {
  model::Tangent state = default_state();     // (36) per m^2, rad^2, (m/s)^2, (rad/s)^2
  model::Input input = model::Input::Ones();  // (12) per rad^2 of u_up

  /// Weights that carried eight motions in a feasibility study; a motion's file overrides them.
  static model::Tangent default_state() {
    model::Tangent w;
    w.segment<3>(model::kDPos) << 300.0, 300.0, 1000.0;  // base x, y, z
    w.segment<3>(model::kDTheta) << 60.0, 60.0, 20.0;    // roll, pitch, yaw
    w.segment<model::kNumJoints>(model::kDJoint).setConstant(3.0);
    w.segment<3>(model::kDVel).setConstant(3.0);
    w.segment<3>(model::kDOmega) << 0.3, 0.3, 0.1;
    w.segment<model::kNumJoints>(model::kDJointRate).setConstant(0.02);
    return w;
  }
};

/// (x ⊖ x_ref)' W (x ⊖ x_ref), of a knot.
inline double state_cost(const CostWeights& w, const model::State& x, const model::State& x_ref) {
  const model::Tangent e = model::minus(x, x_ref);
  return e.dot(w.state.cwiseProduct(e));
}

/// u' W u of what the upper layer adds, rad.
inline double input_cost(const CostWeights& w, const model::Input& u_upper) {
  return u_upper.dot(w.input.cwiseProduct(u_upper));
}

/// One 60 ms term of the performance J of a trial.
inline double stage_cost(const CostWeights& w, const model::State& x, const model::State& x_ref,
                         const model::Input& u_upper) {
  return state_cost(w, x, x_ref) + input_cost(w, u_upper);
}

}  // namespace sanso::mpc
