// Fills the solver's problem from the trial's context: references, other layers, start state;
// then turns its first knots into the policy that is sent.
#include "host/mpc/upper_layer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/mpc/delay_prediction.h"
#include "host/mpc/noise_phases.h"
#include "host/mpc/solver.h"

namespace sanso::mpc {

struct UpperLayer::Impl {
  Impl(const MpcSettings& s, const host::AugmentedModel& m)
      : settings(s),
        model(m),
        ticks_per_knot(
            std::max(1, static_cast<int>(std::lround(s.dt_s / to_seconds(kTickPeriod))))),
        pool(s.threads, s.pin_threads),
        phases({s.horizon, s.dt_s, s.difference_step}, m, pool),
        noisy(noise_phases()),
        solver({s.max_iterations, s.convergence, s.regularization, s.input_limit_rad,
                s.one_noise_channel},
               noisy ? static_cast<Phases&>(*noisy) : phases) {}

  /// Null: no noise has slopes.
  std::unique_ptr<NoisePhases> noise_phases() {
    const NoiseSettings noise{settings.noise_slope, settings.one_noise_channel, settings.spread};
    if (!noise.input_slope && noise.spread == 0.0) return nullptr;
    const Op3PhasesSettings of_all{settings.horizon, settings.dt_s, settings.difference_step};
    auto out = std::make_unique<NoisePhases>(noise, of_all, phases, pool);
    out->set_model(model);
    return out;
  }

  void fill_context(std::int32_t plan_tick);
  void fill_stage(int stage, double tick);
  void fill_start(const model::State& x, std::int32_t plan_tick);
  double knot_input(std::size_t k, int i);
  void fill_policy(const PlanRequest& request, PlanResult& result);
  double lag_s() const { return model.analytical.target_lag_s; }

  MpcSettings settings;
  host::AugmentedModel model;
  int ticks_per_knot;
  SpinPool pool;
  Op3Phases phases;
  std::unique_ptr<NoisePhases> noisy;
  Solver solver;
  DelayPrediction delay;
  TrialContext trial;
  policy::Knot knot;      // scratch
  bool has_last = false;  // a plan of this trial is in the solver
  std::int32_t last_plan_tick = 0;
};

void UpperLayer::Impl::fill_stage(int stage, double tick) {
  StageContext& c = phases.context().stage[stage];
  // of the targets that act in it
  const double middle_of_step = tick + 0.5 * ticks_per_knot - lag_s() / to_seconds(kTickPeriod);
  const model::State reference = reference_at(trial, middle_of_step);
  const model::Input u_lower =
      trial.on.lower ? model::Input(model::joints(reference)) : trial.u_rest;
  c.has_middle = trial.on.middle && trial.middle != nullptr && !trial.middle->knots.empty();
  for (int i = 0; i < kNu; ++i) c.u_fixed[i] = u_lower[i];
  if (!c.has_middle) return;
  policy::sample_middle(*trial.middle, middle_of_step, knot);
  for (int i = 0; i < kNu; ++i) {
    c.u_fixed[i] += knot.u[i];
    for (int j = 0; j < kNdx; ++j) c.K_middle[i][j] = knot.K(i, j);
  }
  // the error that K multiplies is taken where x is: at the beginning of the step
  policy::sample_middle(*trial.middle, tick, knot);
  for (int i = 0; i < kNx; ++i) c.x_middle[i] = knot.x[i];
}

void UpperLayer::Impl::fill_context(std::int32_t plan_tick) {
  ProblemContext& c = phases.context();
  for (int k = 0; k < settings.horizon; ++k) {
    const double tick = plan_tick + static_cast<double>(k) * ticks_per_knot;
    const model::State reference = reference_at(trial, tick);
    std::copy_n(reference.data(), kNx, c.x_ref[k]);
    if (k + 1 < settings.horizon) fill_stage(k, tick);
  }
  std::copy_n(trial.weights.state.data(), kNdx, c.state_weight);
  std::copy_n(trial.weights.input.data(), kNu, c.input_weight);
  c.reflex.on = trial.on.reflex;
  c.reflex.settings = trial.reflex;
  for (int i = 0; i < kNu; ++i) {
    c.reflex.lower[i] = model::kJoints[static_cast<std::size_t>(i)].lower_rad;
    c.reflex.upper[i] = model::kJoints[static_cast<std::size_t>(i)].upper_rad;
  }
}

/// u_up = 0, or the last plan moved on by the time that has passed (its last input repeated).
void UpperLayer::Impl::fill_start(const model::State& x, std::int32_t plan_tick) {
  Trajectory& t = solver.trajectory();
  const int stages = settings.horizon - 1;
  const int shift = std::clamp((plan_tick - last_plan_tick) / ticks_per_knot, 0, stages);
  const bool warm = settings.warm_start && has_last;
  for (int k = 0; k < stages; ++k)
    for (int i = 0; i < kNu; ++i) t.u[k][i] = warm ? t.u[std::min(k + shift, stages - 1)][i] : 0.0;
  std::copy_n(x.data(), kNx, t.x[0]);
}

/// Input of a knot. The plan holds one input for a whole step; between knots the controller goes on
/// a straight line. So knots stand for instants: each has the mean of the steps on both its sides.
/// The first has its step's own; where a line through two steps would lead, noise is led twice.
double UpperLayer::Impl::knot_input(std::size_t k, int i) {
  const auto& u = solver.trajectory().u;
  return settings.inputs_at_knots || k == 0 ? u[k][i] : 0.5 * (u[k - 1][i] + u[k][i]);
}

void UpperLayer::Impl::fill_policy(const PlanRequest& request, PlanResult& result) {
  policy::UpperPolicy& p = result.policy;
  p.sequence = request.sequence;
  p.trial_id = trial.trial_id;
  p.first_tick = request.plan_tick;
  p.ticks_per_knot = ticks_per_knot;
  const auto count =
      std::min<std::size_t>(policy::kMaxUpperKnots, static_cast<std::size_t>(settings.horizon - 1));
  p.knots.try_resize(count);
  // what acts later is asked for now: so many whole steps and a share of one ahead
  const double ahead = lag_s() / settings.dt_s, whole = std::floor(ahead), share = ahead - whole;
  for (std::size_t k = 0; k < count; ++k) {
    policy::Knot& out = p.knots[k];
    const StageGains& gains = solver.gains()[k];
    const std::size_t at = std::min(k + static_cast<std::size_t>(whole), count - 1),
                      after = std::min(at + 1, count - 1);
    double norm2 = 0;
    for (int i = 0; i < kNu; ++i) {
      out.u[i] = knot_input(at, i) + share * (knot_input(after, i) - knot_input(at, i));
      for (int j = 0; j < kNdx; ++j) norm2 += gains.K[i][j] * gains.K[i][j];
    }
    const double norm = std::sqrt(norm2);
    const double scale = norm > settings.gain_norm_limit ? settings.gain_norm_limit / norm : 1.0;
    for (int i = 0; i < kNu; ++i)
      for (int j = 0; j < kNdx; ++j) out.K(i, j) = scale * gains.K[i][j];
    for (int i = 0; i < kNx; ++i) out.x[i] = solver.trajectory().x[k][i];
    result.gain_norm = std::max(result.gain_norm, norm);
  }
}

UpperLayer::UpperLayer(const MpcSettings& settings, const host::AugmentedModel& model)
    : impl_(std::make_unique<Impl>(settings, model)) {}

UpperLayer::~UpperLayer() = default;

void UpperLayer::set_model(const host::AugmentedModel& model) {
  impl_->model = model;
  impl_->phases.set_model(model);
  if (impl_->noisy) impl_->noisy->set_model(model);
}

void UpperLayer::begin_trial(const TrialContext& context) {
  impl_->trial = context;
  impl_->has_last = false;
}

void UpperLayer::plan(const PlanRequest& request, PlanResult& result) {
  Impl& s = *impl_;
  const Nanoseconds start = steady_now();
  result.status = Status::not_ready;
  result.policy.knots.clear();
  result.gain_norm = 0;
  if (s.trial.reference.empty()) return;
  if (!request.x_observed.allFinite()) {
    result.status = Status::out_of_range;
    return;
  }
  const SpinPool::Session session(s.pool);
  result.x_plan = request.x_observed;
  if (s.settings.delay_prediction)
    result.x_plan = s.delay.predict(s.model, s.phases.residual(), s.trial, request,
                                    s.settings.one_step_prediction);
  s.fill_context(request.plan_tick);
  s.fill_start(result.x_plan, request.plan_tick);
  const Nanoseconds predicted = steady_now();

  SolveResult solved;
  const Nanoseconds deadline = request.time_budget > 0 ? start + request.time_budget : 0;
  double sigma = request.sigma < 0 ? s.settings.sigma : request.sigma;
  if (s.settings.noise_over_root_dt) sigma /= std::sqrt(s.settings.dt_s);
  s.solver.solve(sigma, deadline, solved);
  s.has_last = solved.finite;
  s.last_plan_tick = request.plan_tick;
  result.status = solved.finite ? Status::ok : Status::out_of_range;
  if (solved.finite) s.fill_policy(request, result);
  result.cost_before = solved.cost_before;
  result.cost_after = solved.cost_after;
  result.expected_cost = solved.expected_cost;
  result.iterations = solved.iterations;
  result.stop = solved.stop;
  result.timing = solved.timing;
  result.timing.predict = predicted - start;
  result.timing.total = steady_now() - start;
}

}  // namespace sanso::mpc
