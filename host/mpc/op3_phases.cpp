// The solver's phases as items of work for the pool: each item writes its own stage or lanes, so
// the result does not depend on the number of threads.
#include "host/mpc/op3_phases.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "shared/model/state_layout.h"
#include "shared/policy/layer_kernels.h"

namespace sanso::mpc {
namespace {

using model::Input;
using model::State;
using model::Tangent;

Eigen::Map<const State> as_state(const double* x) { return Eigen::Map<const State>(x); }

double exponential(double v) { return std::exp(v); }

// Lane arrays seen as the batch step's arguments: the same memory, [component][lane].
model::StateLanes& as_lanes(double (*x)[kEvaluationLanes]) {
  return *reinterpret_cast<model::StateLanes*>(x);
}
model::InputLanes& as_input(double (*u)[kEvaluationLanes]) {
  return *reinterpret_cast<model::InputLanes*>(u);
}
model::StateQuad& as_quad(double (*x)[kRollOutLanes]) {
  return *reinterpret_cast<model::StateQuad*>(x);
}

}  // namespace

static_assert(kEvaluationLanes == model::kLanes && kRollOutLanes == model::kQuadLanes);

Op3Phases::Op3Phases(const Op3PhasesSettings& settings, const host::AugmentedModel& model,
                     SpinPool& pool, const LaneKernels& kernels)
    : settings_(settings), pool_(pool), kernels_(kernels), work_(std::make_unique<Workspace>()) {
  std::memset(static_cast<void*>(work_.get()), 0, sizeof(Workspace));
  set_model(model);
}

void Op3Phases::set_model(const host::AugmentedModel& model) {
  model_ = model;
  work_->residual.present = false;
  if (model_.residual) fold(*model_.residual, work_->residual);
  Op3Phases::begin_solve();  // what was kept is another network's
}

model::State Op3Phases::nominal_next(int stage) const {
  const model::StateLanes& lanes = work_->whole_x[kNominal][stage / model::kLanes];
  return State::NullaryExpr([&](Eigen::Index i) { return lanes.v[i][stage % model::kLanes]; });
}

void Op3Phases::start_contact_from(const Op3Phases& other) {
  std::memcpy(work_->nominal_contact, other.work_->nominal_contact, sizeof work_->nominal_contact);
}

bool Op3Phases::ground_varies() const {
  const model::GroundSegment& first = model_.ground.segment[0];
  return model_.ground.num_segments > 1 || first.sin_slope != 0 || first.curvature != 0;
}

void Op3Phases::roll_out(const LinePolicy& policy, const double* steps, LaneTrajectories& out) {
  pool_.run(kRollOutGroups, [&](int group, int) {
    roll_out_group(policy, steps + group * kRollOutLanes, group, out.group[group]);
  });
}

void Op3Phases::roll_out_group(const LinePolicy& policy, const double* steps, int group,
                               LaneGroup& out) {
  const Trajectory& nominal = *policy.nominal;
  for (int i = 0; i < kNx; ++i)
    for (int lane = 0; lane < kRollOutLanes; ++lane) out.x[0][i][lane] = nominal.x[0][i];
  std::memset(out.cost, 0, sizeof out.cost);
  std::memset(out.noise_cost, 0, sizeof out.noise_cost);
  model::InputQuad u;
  // Contact from zero: where friction leaves several solutions, it must not depend on the way to
  // this trajectory.
  const model::BatchStep step{
      .h = settings_.dt_s, .substeps = model_.substeps, .warm_start = false};
  for (int k = 0; k < stages(); ++k) {
    const LineStage line{nominal.x[k],
                         nominal.u[k],
                         policy.gains ? policy.gains + k : nullptr,
                         policy.noise ? policy.noise + k : nullptr,
                         steps,
                         policy.input_limit_rad};
    kernels_.line_inputs(line, out.x[k], out.u[k], out.noise_cost);
    kernels_.layer_inputs(work_->context.stage[k], work_->context.reflex, out.x[k], out.u[k], u.v);
    kernels_.add_cost(work_->context, k, out.x[k], out.u[k], out.cost);
    model::step_quad(model_.analytical, model_.ground, as_quad(out.x[k]), u, step,
                     as_quad(out.x[k + 1]), &work_->rolled_contact[group][k]);
    if (residual()) kernels_.add_residual(*residual(), 1.0, out.x[k], u.v, out.x[k + 1]);
  }
  kernels_.add_cost(work_->context, stages(), out.x[stages()], nullptr, out.cost);
  for (double& cost : out.cost)
    if (!std::isfinite(cost)) cost = std::numeric_limits<double>::infinity();
}

void Op3Phases::lane_taken(int lane) {
  const model::ContactQuad* contact = work_->rolled_contact[lane / kRollOutLanes];
  for (int k = 0; k < stages(); ++k)
    for (int i = 0; i < model::kNumContactRows; ++i)
      work_->nominal_contact[k][i] = contact[k].v[i][lane % kRollOutLanes];
}

void Op3Phases::begin_solve() {
  for (KeptJacobian& kept : work_->jacobian) kept.present = false;
}

void Op3Phases::linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                          StageCost* costs) {
  begin_linearize(nominal, derivatives, costs);
  finish_linearize();
}

void Op3Phases::begin_linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                                StageCost* costs) {
  pool_.run(stages(), [&](int stage, int) { prepare_stage(nominal, stage); });
  pool_.run(stage_groups() * (ground_varies() ? 3 : 2),
            [&](int item, int) { evaluate_whole(nominal, item); });
  cost_model(work_->context, stages(), nominal.x[stages()], nullptr, costs[stages()]);
  for (std::atomic<bool>& done : stage_done_) done.store(false, std::memory_order_relaxed);
  stages_ = {this, &nominal, derivatives, costs};
  pool_.begin(stages(), stages_);
}

/// All of a stage on one thread: what its evaluations hold stays in that processor's cache.
void Op3Phases::StageWork::operator()(int item, int) const {
  const int stage = phases->stages() - 1 - item;  // the backward pass begins with the last one
  phases->evaluate_stage(nominal->x[stage], stage);
  phases->finish_stage(*this, stage);
  phases->stage_done_[stage].store(true, std::memory_order_release);
}

void Op3Phases::wait_for(int stage) {
  while (!stage_done_[stage].load(std::memory_order_acquire))
    if (!pool_.help()) pool_.finish();
}

void Op3Phases::prepare_stage(const Trajectory& nominal, int stage) {
  const StageContext& c = work_->context.stage[stage];
  const ReflexContext& reflex = work_->context.reflex;
  Nominal& n = work_->nominal[stage];
  const double* x = nominal.x[stage];
  std::memset(n.layer_slope, 0, sizeof n.layer_slope);
  for (int i = 0; i < kNu; ++i) n.u_without_upper[i] = c.u_fixed[i];
  if (c.has_middle) {
    const Tangent dx = model::minus(as_state(x), as_state(c.x_middle));
    const math::Mat3 J = math::right_jacobian_inverse(dx.segment<3>(model::kDTheta));
    const auto gain = [&](int i, int j) { return c.K_middle[i][j]; };
    policy::affine_kernel(c.u_fixed, gain, dx, n.u_without_upper);
    for (int i = 0; i < kNu; ++i) {
      for (int j = 0; j < kNdx; ++j) n.layer_slope[i][j] = c.K_middle[i][j];
      for (int j = 0; j < 3; ++j)
        n.layer_slope[i][kTheta + j] = c.K_middle[i][kTheta] * J(0, j) +
                                       c.K_middle[i][kTheta + 1] * J(1, j) +
                                       c.K_middle[i][kTheta + 2] * J(2, j);
    }
  }
  if (reflex.on) {
    for (int i = 0; i < kNu; ++i) {
      const double q = x[model::kXJoint + i], sharpness = reflex.settings.sharpness;
      n.u_without_upper[i] += policy::reflex_complement_kernel(q, reflex.lower[i], reflex.upper[i],
                                                               reflex.settings, exponential);
      const double below = policy::zeta(reflex.lower[i] - q, sharpness, exponential),
                   above = policy::zeta(q - reflex.upper[i], sharpness, exponential);
      n.layer_slope[i][model::kDJoint + i] -=
          reflex.settings.gain * sharpness * (below * (1 - below) + above * (1 - above));
    }
  }
  for (int i = 0; i < kNu; ++i) n.u_total[i] = n.u_without_upper[i] + nominal.u[stage][i];
}

/// From the nominal contact solution, to the tolerance of the solver: what is left over is divided
/// by the difference.
void Op3Phases::evaluate_whole(const Trajectory& nominal, int item) {
  const model::BatchStep step{.h = settings_.dt_s, .substeps = model_.substeps, .warm_start = true};
  const int whole = item / stage_groups(), group = item % stage_groups(),
            first = group * model::kLanes;
  const int lanes = std::min(model::kLanes, stages() - first);
  model::StateLanes& x = work_->whole_x[whole][group];
  model::InputLanes u;
  model::ContactLanes contact;
  for (int lane = 0; lane < model::kLanes; ++lane) {
    const int stage = first + (lane < lanes ? lane : 0);  // idle lanes repeat the first
    const Nominal& n = work_->nominal[stage];
    for (int i = 0; i < model::kNumContactRows; ++i)
      contact.v[i][lane] = work_->nominal_contact[stage][i];
    for (int i = 0; i < kNx; ++i) x.v[i][lane] = nominal.x[stage][i];
    for (int i = 0; i < kNu; ++i)
      u.v[i][lane] = whole == kWithoutUpper ? n.u_without_upper[i] : n.u_total[i];
    if (whole == kAlongX) x.v[0][lane] += settings_.difference_step;
  }
  if (whole == kNominal && shares()) {
    model::step_batch_keep(model_.analytical, model_.ground, x, u, step, x, &contact,
                           work_->step + first, lanes);
  } else {
    model::step_batch(model_.analytical, model_.ground, &x, &u, step, &x, &contact, 1);
  }
}

void Op3Phases::evaluate_stage(const double* x_nominal, int stage) {
  StageEvaluations& e = work_->evaluations[stage];
  kernels_.spread(x_nominal, work_->nominal[stage].u_total, settings_.difference_step,
                  0.5 * settings_.dt_s, e);
  model::StateLanes* x = &as_lanes(e.x[0]);
  const model::InputLanes* u = &as_input(e.u[0]);
  if (shares()) {
    constexpr int held = kConfigurationGroups;  // the others share the mass matrix
    model::step_held(model_.analytical, model_.ground, work_->step[stage], x, u, settings_.dt_s, x,
                     held);
    model::step_neighbours(model_.analytical, work_->step[stage], x + held, u + held,
                           settings_.dt_s, x + held, kEvaluationGroups - held);
    return;
  }
  const model::BatchStep step{.h = settings_.dt_s, .substeps = model_.substeps, .warm_start = true};
  for (int g = 0; g < kEvaluationGroups; ++g) {
    model::ContactLanes contact;
    for (int i = 0; i < model::kNumContactRows; ++i)
      for (int l = 0; l < model::kLanes; ++l) contact.v[i][l] = work_->nominal_contact[stage][i];
    model::step_batch(model_.analytical, model_.ground, x + g, u + g, step, x + g, &contact, 1);
  }
}

void Op3Phases::finish_stage(const StageWork& of, int stage) {
  const double* x = of.nominal->x[stage];
  cost_model(work_->context, stage, x, of.nominal->u[stage], of.costs[stage]);
  const Nominal& n = work_->nominal[stage];
  double whole[kWholeSteps][kNx];
  for (int step = 0; step < kWholeSteps; ++step)
    for (int i = 0; i < kNx; ++i)
      whole[step][i] = work_->whole_x[step][stage / model::kLanes].v[i][stage % model::kLanes];
  const StageFinish finish{.evaluations = &work_->evaluations[stage],
                           .x = x,
                           .u_total = n.u_total,
                           .u_without_upper = n.u_without_upper,
                           .next = whole[kNominal],
                           .without_upper = whole[kWithoutUpper],
                           .along_x = ground_varies() ? whole[kAlongX] : nullptr,
                           .layer_slope = n.layer_slope,
                           .residual = residual(),
                           .jacobian = &work_->jacobian[stage],
                           .difference_step = settings_.difference_step,
                           .half_step_s = 0.5 * settings_.dt_s};
  kernels_.finish_stage(finish, of.derivatives[stage]);
}

void cost_model(const ProblemContext& context, int knot, const double* x, const double* u,
                StageCost& out) {
  const Tangent e = model::minus(as_state(x), as_state(context.x_ref[knot]));
  const double* w = context.state_weight;
  // e(x ⊕ d) = e + J d with J = identity but for the orientation, where it is the inverse right
  // Jacobian of Exp
  const math::Mat3 J = math::right_jacobian_inverse(e.segment<3>(kTheta));
  const math::Vec3 w_theta(w[kTheta], w[kTheta + 1], w[kTheta + 2]);
  for (int i = 0; i < kNdx; ++i) {
    out.lx[i] = 2 * w[i] * e[i];
    out.lxx_diagonal[i] = 2 * w[i];
  }
  const math::Vec3 slope = 2 * J.transpose() * w_theta.cwiseProduct(e.segment<3>(kTheta));
  const math::Mat3 curvature = 2 * J.transpose() * w_theta.asDiagonal() * J;
  for (int i = 0; i < 3; ++i) {
    out.lx[kTheta + i] = slope[i];
    for (int j = 0; j < 3; ++j) out.lxx_theta[i][j] = curvature(i, j);
  }
  for (int i = 0; i < kNu; ++i) {
    out.lu[i] = u ? 2 * context.input_weight[i] * u[i] : 0;
    out.luu_diagonal[i] = u ? 2 * context.input_weight[i] : 0;
  }
}

}  // namespace sanso::mpc
