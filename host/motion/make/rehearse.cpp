// A loop of plan, guard, and model at 2 ms; soles are looked at in every one of these steps.
#include "host/motion/make/rehearse.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "host/motion/catalogue.h"
#include "host/motion/dmp_fit.h"
#include "host/mpc/upper_layer.h"
#include "shared/base/time.h"
#include "shared/model/op3_step.h"
#include "shared/policy/layer_sum.h"

namespace sanso::motion {
namespace {

constexpr int kTicksPerKnot = 2, kStepsPerTick = 5;
constexpr double kStep_s = kTick_s / kStepsPerTick;
constexpr double kFallen_rad = 0.6, kFallen_m = 0.15;
/// Of u_up in trials [1/rad^2]: the targets hold already what the planner would add to others, and
/// what it adds every 60 ms blurs the flight (measured: docs/results/jog-flight.md).
constexpr double kInputWeight = 3.0;

mpc::MpcSettings planner_settings(const RehearsalSettings& settings) {
  mpc::MpcSettings s;
  s.dt_s = kTicksPerKnot * kTick_s;
  s.horizon = mpc::kMaxHorizon;  // 0.46 s: more than a step
  s.max_iterations = 4;          // from the last plan it needs two or three
  s.warm_start = true;
  s.delay_prediction = false;
  s.threads = 1;
  s.input_limit_rad = settings.input_limit_rad;
  return s;
}

mpc::CostWeights weights_of(const RehearsalSettings& settings) {
  mpc::CostWeights w;
  w.state[model::kDPos + 2] = settings.base_z;
  w.state[model::kDVel + 2] = settings.base_rise;
  w.state.segment<model::kNumJoints>(model::kDJoint).setConstant(settings.joints);
  w.state.segment<model::kNumJoints>(model::kDJointRate).setConstant(settings.joint_rates);
  w.input.setConstant(settings.input);
  return w;
}

host::AugmentedModel planners(model::StepModel model, const RehearsalSettings& settings) {
  for (model::ServoParameters& servo : model.servo)
    servo.torque_limit = std::min(servo.torque_limit, settings.torque_limit_Nm);
  host::AugmentedModel out;
  out.analytical = model;
  return out;
}

/// Counts what the soles do between the second lift and the last landing.
class Soles {
 public:
  explicit Soles(const StepPlan& plan)
      : from_s_(plan.swings[1].lift_s - 0.05), to_s_(plan.swings.back().land_s) {}

  void look(double t, const model::StepScratch& step, Rehearsal& out) {
    if (t < from_s_ || t >= to_s_) return;
    std::array<double, 2> load{};
    for (std::size_t f = 0; f < 2; ++f)
      for (int k = 0; k < model::kCornersPerFoot; ++k) load[f] += step.lambda[f][k][2] / kStep_s;
    const bool right = load[0] >= kUnloaded_N, left = load[1] >= kUnloaded_N;
    if (!right && !left) {
      ++free_;
    } else if (free_ > 0) {
      out.flights_s.push_back(free_ * kStep_s);
      free_ = 0;
    }
    both_ += right && left ? 1 : 0;
    ++all_;
    out.double_support_share = static_cast<double>(both_) / all_;
  }

 private:
  double from_s_, to_s_;
  int free_ = 0, both_ = 0, all_ = 0;
};

class Stage {
 public:
  Stage(const FlightReference& reference, const model::StepModel& model,
        const RehearsalSettings& settings)
      : reference_(reference.body.trajectory.x),
        settings_(settings),
        model_(planners(model, settings)),
        planner_(planner_settings(settings), model_),
        soles_(reference.plan),
        x_(reference_.front()),
        u_(model::joints(reference_.front())) {
    mpc::TrialContext context;
    context.trial_id = 1;
    context.reference = reference_;
    context.weights = weights_of(settings);
    planner_.begin_trial(context);
  }

  Rehearsal run() {
    Rehearsal out;
    for (std::size_t k = 0; k < reference_.size(); ++k) {
      if (!tell(static_cast<int>(k))) return out;
      out.told.x.push_back(x_);
      out.told.x.back().segment<model::kNumJoints>(model::kXJoint) = u_;
      move(static_cast<double>(k) * kTick_s, out);
      const math::Mat3 R = math::rotation_matrix(model::base_quat(x_));
      out.largest_tilt_rad =
          std::max(out.largest_tilt_rad, std::acos(std::clamp(R(2, 2), -1.0, 1.0)));
      if (out.largest_tilt_rad > kFallen_rad || x_[2] < kFallen_m) return out;
    }
    out.upright = true;
    out.place_error_m = (x_.head<2>() - reference_.back().head<2>()).norm();
    return out;
  }

 private:
  /// New targets; false when the planner has no answer.
  bool tell(int tick) {
    if (tick % kTicksPerKnot == 0) {
      mpc::PlanRequest request;
      request.observed_tick = request.plan_tick = tick;
      request.x_observed = x_;
      request.sequence = static_cast<std::uint32_t>(tick) + 1;
      request.sigma = 0.0;
      planner_.plan(request, *plan_);
      if (plan_->status != Status::ok) return false;
    }
    policy::sample_upper(plan_->policy, tick, *knot_);
    const model::Input wanted =
        model::joints(reference_[static_cast<std::size_t>(tick)]) + policy::affine(*knot_, x_);
    const double most = settings_.target_rate_rad_s * kTick_s;
    for (int j = 0; j < model::kNumJoints; ++j) {
      const double q = x_[model::kXJoint + j];
      const double near =
          std::clamp(wanted[j], q - settings_.target_offset_rad, q + settings_.target_offset_rad);
      u_[j] += std::clamp(near - u_[j], -most, most);
    }
    return true;
  }

  void move(double t, Rehearsal& out) {
    for (int i = 0; i < kStepsPerTick; ++i) {
      model::StepScratch scratch;
      model::State next;
      model::analytical_step(model_.analytical, model_.ground, x_.data(), u_.data(), kStep_s, 1,
                             next.data(), scratch);
      x_ = next;
      soles_.look(t + i * kStep_s, scratch, out);
    }
  }

  const std::vector<model::State>& reference_;
  RehearsalSettings settings_;
  host::AugmentedModel model_;
  mpc::UpperLayer planner_;
  Soles soles_;
  std::unique_ptr<mpc::PlanResult> plan_ = std::make_unique<mpc::PlanResult>();
  std::unique_ptr<policy::Knot> knot_ = std::make_unique<policy::Knot>();
  model::State x_;
  model::Input u_;
};

}  // namespace

double Rehearsal::flight_share(double at_least_s) const {
  constexpr double kRounding_s = 1e-6;
  const auto long_enough = std::count_if(flights_s.begin(), flights_s.end(),
                                         [&](double s) { return s >= at_least_s - kRounding_s; });
  return static_cast<double>(long_enough) / steps;
}

Rehearsal rehearse(const FlightReference& reference, const model::StepModel& model,
                   const RehearsalSettings& settings) {
  Rehearsal out = Stage(reference, model, settings).run();
  out.steps = static_cast<double>(reference.plan.swings.size()) - 1.0;
  if (!out.told.x.empty()) differentiate_poses(out.told);
  return out;
}

Motion jog_motion(const std::string& name, const FlightJog& figures,
                  const FlightReference& reference, const Rehearsal& rehearsal,
                  const RehearsalSettings& settings) {
  if (!rehearsal.upright)
    throw MotionError(name + ": the robot falls in its model; lower lift_off_m_s or flight_s");
  Motion m = catalogue_entry("jog");
  m.name = name;
  m.title = "Jogging forward, with flight";
  m.source = {"own", "Apache-2.0", "computed, rehearsed on the model of a robot"};
  m.flight = figures;
  m.target_rate_rad_s = settings.target_rate_rad_s;
  m.window = {reference.plan.swings.front().lift_s, reference.plan.swings.back().land_s};
  for (Clause& clause : m.success) clause.waived.clear();
  m.weights.state[model::kDPos + 2] = 300.0;
  m.weights.state.segment<model::kNumJoints>(model::kDJoint).setConstant(0.05);
  m.weights.state.segment<model::kNumJoints>(model::kDJointRate).setConstant(0.001);
  m.weights.input.setConstant(kInputWeight);
  constexpr double kFadeStart = 0.95;
  const double most = (policy::kMaxBasis - 1) / rehearsal.told.duration_s();
  m.primitives =
      fit_discrete(rehearsal.told, {std::min(figures.basis_per_second, most), kFadeStart});
  return parse_motion(to_toml(m), name);  // rounded to what the file holds
}

double worth(const Rehearsal& r) {
  // a flight is worth its length up to 38 ms and, for half of a step each, 20 and 28 ms of it: the
  // robot keeps a little less than the model. The rest is the price of what a jog must not do.
  constexpr double kLongest_s = 0.038, kPer_s = 1000.0, kDoubleSupport = 0.03;
  double flown = 0.0;
  for (const double s : r.flights_s) flown += std::min(s, kLongest_s);
  return kPer_s * flown / r.steps + 40.0 * std::min(1.0, r.flight_share(0.02)) +
         60.0 * std::min(1.0, r.flight_share(0.028)) -
         150.0 * std::max(0.0, r.double_support_share - kDoubleSupport) -
         60.0 * r.largest_tilt_rad - 100.0 * r.place_error_m - (r.upright ? 0.0 : 100.0);
}

}  // namespace sanso::motion
