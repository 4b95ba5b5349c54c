// The model stage, written down as a session writes what a controller says.
#include "host/app/model_trial.h"

#include <algorithm>
#include <cmath>

#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/model_stage.h"
#include "shared/model/step_model.h"

namespace sanso::app {
namespace {

using motion::ModelStage;
using motion::Motion;
using motion::StageSettings;

constexpr float kSupply_V = 12.0F;

StageSettings stage_of(const Motion& motion) {
  StageSettings out;
  out.planner.delay_prediction = false;
  out.planner.threads = 1;
  if (motion.target_rate_rad_s) out.target_rate_rad_s = *motion.target_rate_rad_s;
  return out;
}

/// Specific force and rates of the base between two ticks, base axes.
void feel(const model::State& before, const model::State& after, wire::Observation& o) {
  const math::Mat3 R = math::rotation_matrix(model::base_quat(before));
  math::Vec3 force = (after.segment<3>(model::kXVel) - before.segment<3>(model::kXVel)) / kTick_s;
  force[2] += model::kGravity_m_s2;
  const math::Vec3 felt = R.transpose() * force;
  for (int i = 0; i < 3; ++i) {
    o.imu_acc[static_cast<std::size_t>(i)] = felt[i];
    o.imu_gyro[static_cast<std::size_t>(i)] = before[model::kXVel + 3 + i];
  }
}

learn::TrueSample seen(const model::State& x, const ModelStage::Loads& loads) {
  learn::TrueSample out;
  out.x = x;
  const motion::BodyPoints points = motion::body_points(x);
  for (int side = 0; side < 2; ++side) {
    const auto s = static_cast<std::size_t>(side);
    double lowest = INFINITY;
    for (const math::Vec3& corner : points.sole_corners(side))
      lowest = std::min(lowest, corner.z());
    out.foot_clearance_m[s] = static_cast<float>(lowest);
    out.foot_load_N[s] = static_cast<float>(loads[s]);
  }
  return out;
}

/// What ends a trial early, if anything does.
learn::TrialEnd ending(const Motion& motion, const model::State& x, const model::State& wanted,
                       double cost) {
  const math::Mat3 R = math::rotation_matrix(model::base_quat(x)),
                   W = math::rotation_matrix(model::base_quat(wanted));
  if (cost > motion.stop.cost_limit) return learn::TrialEnd::cost_limit;
  if (x[model::kXPos + 2] < wanted[model::kXPos + 2] - motion.stop.drop_limit_m)
    return learn::TrialEnd::low_base;
  const double lean = std::acos(std::clamp(R.col(2).dot(W.col(2)), -1.0, 1.0));
  return lean > motion.stop.tilt_limit_rad ? learn::TrialEnd::tilt : learn::TrialEnd::completed;
}

}  // namespace

learn::Episode trial_in_model(const Motion& motion, const host::AugmentedModel& model) {
  const std::vector<model::State> reference = motion.reference().x;
  const StageSettings settings = stage_of(motion);
  ModelStage stage(reference, motion.weights, model, settings);
  learn::Episode out;
  for (std::size_t k = 0; k < reference.size(); ++k) {
    const int tick = static_cast<int>(k);
    wire::Observation o;
    o.tick = k, o.time = static_cast<Nanoseconds>(k) * kTickPeriod, o.trial_tick = tick;
    o.pose_age_ticks = 0, o.voltage_V = kSupply_V;
    o.x = stage.state();
    if (!stage.tell(tick)) {
      out.end = learn::TrialEnd::ended_early;
      return out;
    }
    o.u_upper = stage.upper(), o.u_lower = model::joints(reference[k]);
    o.u_out = stage.targets();
    ModelStage::Loads loads{};
    stage.move([&](int, const ModelStage::Loads& now) { loads = now; });
    feel(o.x, stage.state(), o);
    out.ticks.push_back(o);
    out.truth.push_back(seen(o.x, loads));
    if (tick % settings.ticks_per_plan == 0) {
      out.cost_terms.push_back(mpc::stage_cost(motion.weights, o.x, reference[k], o.u_upper));
      out.cost += out.cost_terms.back();
    }
    out.end = ending(motion, o.x, reference[k], out.cost);
    if (out.failed()) return out;
  }
  return out;
}

}  // namespace sanso::app
