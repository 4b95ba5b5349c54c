// Is there still physics in what is left? (T4, method 3.4 and 3.10): can the missing torque be
// predicted from the joint's state on parts of the recordings that were not used? With a sparse
// description of its shape, which is a description and no name.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/settings.h"
#include "tools/diagnose/stats/curve.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/verdict/missing_torque.h"

namespace sanso::diagnose {

struct Predictability {
  std::size_t joint = 0;
  // cross-validated R^2 of ridge regression on random features of (q, dq, ddq, motor, error)
  double explained = 0.0;
  double p = 1.0;           // by circular block shifts of the torque against the state
  double torque_rms = 0.0;  // N m, of the missing torque
  double noise_rms = 0.0;   // N m, what measurement noise alone would give
};

/// One joint's samples. Too few (`remains.least_samples`): nothing can be said (p = 1).
Predictability predictability(const std::vector<TorqueSample>& samples, std::size_t joint,
                              Random random, const Settings& settings);

/// Sparse regression of the missing torque on a fixed list of terms with physical meaning: forward
/// selection by BIC, coefficients refitted. `text`: "missing torque = -0.12 sign(dq) + 0.03
/// sin(q)"; empty when no term pays.
struct SparseFormula {
  std::string text;
  double explained = 0.0;
  std::vector<std::string> terms;
};
/// One joint's samples. Too few (`remains.least_samples`): no term, nothing explained.
SparseFormula sparse_formula(const std::vector<TorqueSample>& samples, std::size_t joint,
                             const RemainsSettings& settings);

/// Shape curves of the missing torque against q, dq, motor torque, tracking error and time.
std::vector<ShapeCurve> shape_curves(const std::vector<TorqueSample>& samples, std::size_t joint);

}  // namespace sanso::diagnose
