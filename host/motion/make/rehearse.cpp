// The model stage at 2 ms; soles are looked at in every one of these steps.
#include "host/motion/make/rehearse.h"

#include <algorithm>
#include <cmath>

#include "host/motion/catalogue.h"
#include "host/motion/dmp_fit.h"
#include "host/motion/make/model_stage.h"
#include "shared/base/time.h"

namespace sanso::motion {
namespace {

constexpr int kTicksPerKnot = 2;
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

  void look(double t, const ModelStage::Loads& load, Rehearsal& out) {
    if (t < from_s_ || t >= to_s_) return;
    const bool right = load[0] >= kUnloaded_N, left = load[1] >= kUnloaded_N;
    if (!right && !left) {
      ++free_;
    } else if (free_ > 0) {
      out.flights_s.push_back(free_ * ModelStage::kStep_s);
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

Rehearsal run(const std::vector<model::State>& reference, const StepPlan& plan, ModelStage stage) {
  Rehearsal out;
  Soles soles(plan);
  for (std::size_t k = 0; k < reference.size(); ++k) {
    if (!stage.tell(static_cast<int>(k))) return out;
    out.told.x.push_back(stage.state());
    out.told.x.back().segment<model::kNumJoints>(model::kXJoint) = stage.targets();
    stage.move([&](int step, const ModelStage::Loads& loads) {
      soles.look(static_cast<double>(k) * kTick_s + step * ModelStage::kStep_s, loads, out);
    });
    const model::State& x = stage.state();
    const math::Mat3 R = math::rotation_matrix(model::base_quat(x));
    out.largest_tilt_rad =
        std::max(out.largest_tilt_rad, std::acos(std::clamp(R(2, 2), -1.0, 1.0)));
    if (out.largest_tilt_rad > kFallen_rad || x[2] < kFallen_m) return out;
  }
  out.upright = true;
  out.place_error_m = (stage.state().head<2>() - reference.back().head<2>()).norm();
  return out;
}

}  // namespace

double Rehearsal::flight_share(double at_least_s) const {
  constexpr double kRounding_s = 1e-6;
  const auto long_enough = std::count_if(flights_s.begin(), flights_s.end(),
                                         [&](double s) { return s >= at_least_s - kRounding_s; });
  return static_cast<double>(long_enough) / steps;
}

Rehearsal rehearse(const FlightReference& reference, const model::StepModel& model,
                   const RehearsalSettings& settings) {
  const std::vector<model::State>& states = reference.body.trajectory.x;
  const StageSettings stage{planner_settings(settings), kTicksPerKnot, settings.target_rate_rad_s,
                            settings.target_offset_rad};
  Rehearsal out =
      run(states, reference.plan, {states, weights_of(settings), planners(model, settings), stage});
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
