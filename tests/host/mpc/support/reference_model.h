// The planning problem once more, written for clarity only: one state, double precision, dense
// algebra, central differences.
// Shares with the product the step's formula (op3_step.h) and nothing of the lanes, kernels, or the
// solver.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "host/model/augmented_model.h"
#include "host/mpc/stage_context.h"
#include "shared/model/op3_step.h"
#include "shared/model/state_layout.h"

namespace sanso::mpc::reference {

using Jacobian = Eigen::Matrix<double, model::kNdx, kColumns>;

class Model {
 public:
  /// `sweeps` 0: as the model says.
  Model(const host::AugmentedModel& model, const ProblemContext& context, double dt_s,
        int sweeps = 0)
      : model_(model), context_(context), dt_(dt_s) {
    if (sweeps > 0) model_.analytical.contact.sweeps = sweeps;
  }

  /// Middle layer and lower layer: what acts without the upper layer.
  model::Input other_layers(int stage, const model::State& x) const {
    const StageContext& c = context_.stage[stage];
    model::Input u = Eigen::Map<const model::Input>(c.u_fixed);
    if (c.has_middle) {
      const model::Tangent dx = model::minus(x, Eigen::Map<const model::State>(c.x_middle));
      for (int i = 0; i < kNu; ++i)
        for (int j = 0; j < kNdx; ++j) u[i] += c.K_middle[i][j] * dx[j];
    }
    const ReflexContext& r = context_.reflex;
    if (r.on)
      for (int i = 0; i < kNu; ++i) {
        const double q = x[model::kXJoint + i];
        u[i] += r.settings.gain / (1 + std::exp(r.settings.sharpness * (q - r.lower[i])));
        u[i] -= r.settings.gain / (1 + std::exp(r.settings.sharpness * (r.upper[i] - q)));
      }
    return u;
  }

  model::State step(int stage, const model::State& x, const model::Input& u_upper) const {
    const model::Input u = other_layers(stage, x) + u_upper;
    model::State next;
    model::StepScratch scratch;
    model::analytical_step(model_.analytical, model_.ground, x.data(), u.data(), dt_,
                           model_.substeps, next.data(), scratch);
    if (model_.residual) next = model::plus(next, host::residual_tangent(*model_.residual, x, u));
    return next;
  }

  double cost(int knot, const model::State& x) const {
    const model::Tangent e = model::minus(x, Eigen::Map<const model::State>(context_.x_ref[knot]));
    double sum = 0;
    for (int i = 0; i < kNdx; ++i) sum += context_.state_weight[i] * e[i] * e[i];
    return sum;
  }
  double cost(const model::Input& u) const {
    double sum = 0;
    for (int i = 0; i < kNu; ++i) sum += context_.input_weight[i] * u[i] * u[i];
    return sum;
  }

  /// Column c of [A | B] by a difference of total width 2 h about x, u.
  model::Tangent column(int stage, const model::State& x, const model::Input& u, int c,
                        double h) const {
    const auto at = [&](double s) {
      if (c < kNdx) return step(stage, model::plus(x, s * model::Tangent::Unit(c)), u);
      return step(stage, x, u + s * model::Input::Unit(c - kNdx));
    };
    return model::minus(at(h), at(-h)) / (2 * h);
  }
  Jacobian central_differences(int stage, const model::State& x, const model::Input& u,
                               double h) const {
    Jacobian J;
    for (int c = 0; c < kColumns; ++c) J.col(c) = column(stage, x, u, c, h);
    return J;
  }
  const ProblemContext& context() const { return context_; }

 private:
  host::AugmentedModel model_;
  const ProblemContext& context_;
  double dt_;
};

struct Solution {
  std::vector<model::State> x;
  std::vector<model::Input> u;
  double cost = 0;
  int iterations = 0;
  std::vector<double> costs;  // before the first iteration and after each

  /// Cost at the first iteration that gains less than the fraction `convergence`, at most after
  /// max_iterations.
  double cost_stopped(double convergence, int max_iterations) const;
};

/// Textbook iLQG without noise: central differences, dense solves, a finely graded line search,
/// many iterations.
Solution solve(const Model& model, int stages, const model::State& x0, double input_limit_rad,
               int max_iterations);

/// Cost of the closed loop u = clamp(ū + K (x ⊖ x̄)) from x0.
double closed_loop_cost(const Model& model, const model::State& x0,
                        const std::vector<model::State>& x, const std::vector<model::Input>& u,
                        const std::vector<model::Gain>& K, double input_limit_rad);

}  // namespace sanso::mpc::reference
