// Poses are uploaded as motions that do not move: a controller in hold goes to the first pose of
// what it was given last, and balances there by its ankles.
#include "host/learn/session/bring_up.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/learn/model/prediction.h"
#include "shared/files/atomic_file.h"
#include "shared/model/op3_kinematics.h"

namespace sanso::learn {
namespace {

constexpr std::uint32_t kTrialId = 0xB0000000;  // no trial runs; only uploads and arming carry it

/// A motion that stays where it is.
policy::PrimitiveSet still_at(const model::State& x) {
  policy::PrimitiveSet set;
  for (int i = 0; i < 3; ++i)
    set.scalar[static_cast<std::size_t>(i)].start = set.scalar[static_cast<std::size_t>(i)].goal =
        x[model::kXPos + i];
  for (int j = 0; j < model::kNumJoints; ++j) {
    policy::ScalarPrimitive& p = set.scalar[3 + static_cast<std::size_t>(j)];
    p.start = p.goal = x[model::kXJoint + j];
  }
  set.orientation.start = set.orientation.goal = model::base_quat(x);
  return set;
}

/// Middle of a line from `a` to `b` and back: a/2, all of it, a/2.
void there_and_back(const TrunkShift& a, const TrunkShift& b, std::vector<TrunkShift>& out) {
  const TrunkShift half{0.5 * (a.forward_m + b.forward_m), 0.5 * (a.left_m + b.left_m),
                        0.5 * (a.up_m + b.up_m)};
  for (const TrunkShift& s : {half, b, half, a}) out.push_back(s);
}

/// Mean of the newest `ticks` observations, when the robot was at rest in all of them.
bool mean_of(const std::vector<wire::Observation>& seen, std::size_t ticks,
             const BringUpSettings& settings, HeldPose& pose) {
  if (seen.size() < ticks) return false;
  pose.x.setZero();
  pose.u.setZero();
  double squares = 0.0;
  const model::State& first = seen[seen.size() - ticks].x;
  for (std::size_t i = seen.size() - ticks; i < seen.size(); ++i) {
    const wire::Observation& o = seen[i];
    if (o.state != wire::SupervisorState::hold) return false;
    model::State x = o.x;  // q and -q are one orientation
    if (model::base_quat(x).dot(model::base_quat(first)) < 0.0) x.segment<4>(model::kXQuat) *= -1.0;
    pose.x += x / static_cast<double>(ticks);
    pose.u += o.u_out / static_cast<double>(ticks);
    squares += model::joint_rates(x).squaredNorm() + x.segment<3>(model::kXOmega).squaredNorm();
  }
  pose.x.segment<4>(model::kXQuat) = math::quat_normalized(model::base_quat(pose.x));
  const double still = std::sqrt(squares / static_cast<double>(ticks));
  return still < settings.still_rad_s;
}

}  // namespace

std::vector<TrunkShift> bring_up_poses(const BringUpSettings& s) {
  const TrunkShift stand, forward{s.forward_m, 0, 0}, half{0.5 * s.forward_m, 0, 0};
  const TrunkShift low{half.forward_m, 0, -s.squat_m};
  const TrunkShift left{half.forward_m, s.side_m, 0}, right{half.forward_m, -s.side_m, 0};
  std::vector<TrunkShift> poses{stand};
  there_and_back(stand, forward, poses);
  poses.push_back(half);
  there_and_back(half, low, poses);
  there_and_back(half, left, poses);
  there_and_back(half, right, poses);
  poses.push_back(stand);
  return poses;
}

model::State shifted_stand(const TrunkShift& shift) {
  const model::State stand = model::standing_state();
  model::Kinematics wanted, kin;
  model::forward_kinematics(stand, wanted);
  model::State x = stand;
  x.segment<3>(model::kXPos) += math::Vec3(shift.forward_m, shift.left_m, shift.up_m);
  constexpr int kSteps = 8;  // Newton: centimetres to nanometres in five
  for (int step = 0; step < kSteps; ++step) {
    model::forward_kinematics(x, kin);
    for (int foot = 0; foot < model::kNumFeet; ++foot) {
      const int body = model::foot_body(foot), first = 6 * foot;
      Eigen::Matrix<double, 6, 1> way;
      const math::Mat3 turn = wanted.R_world_link[body] * kin.R_world_link[body].transpose();
      way << wanted.p_world_link[body] - kin.p_world_link[body],
          0.5 *
              math::Vec3(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
      Eigen::Matrix<double, 6, model::kNv> J;
      J << model::point_jacobian(kin, body, kin.p_world_link[body]),
          model::rotation_jacobian(kin, body);
      const Eigen::Matrix<double, 6, 6> leg = J.middleCols<6>(6 + first);
      x.segment<6>(model::kXJoint + first) += leg.partialPivLu().solve(way);
    }
  }
  return x;
}

void hold_pose(link::RobotLink& robot, const TrunkShift& shift, double hold_s) {
  upload_primitives(robot, still_at(shifted_stand(shift)));
  const Nanoseconds end = robot.clock().now() + from_seconds(hold_s);
  while (robot.clock().now() < end) robot.wait_observation(end);
}

HeldPoses hold_poses(link::RobotLink& robot, const BringUpSettings& settings,
                     const TrialSettings& trial) {
  TrialSetup setup;
  setup.trial_id = kTrialId;
  setup.layers.middle = setup.layers.upper = false;
  const std::vector<TrunkShift> poses = bring_up_poses(settings);
  const std::vector<model::State> first{shifted_stand(poses.front())};
  const policy::PrimitiveSet at_first = still_at(first.front());
  setup.primitives = &at_first;
  setup.reference = first;
  HeldPoses held;
  try {
    held.seen = prepare_trial(robot, setup, trial).seen;
  } catch (const FellBefore& fell) {
    held.stopped = fell.what();
    held.seen = fell.preparation.seen;
    return held;
  }
  const auto ticks =
      static_cast<std::size_t>(std::lround(settings.measure_s / to_seconds(kTickPeriod)));
  for (const TrunkShift& shift : poses) {
    hold_pose(robot, shift, settings.hold_s);
    for (const wire::Observation& o : robot.take_observations()) held.seen.push_back(o);
    if (robot.latest().state != wire::SupervisorState::hold) {
      if (robot.latest().fault == kFaultEmergencyStop)
        throw StoppedBefore("bring-up: somebody pressed the emergency stop");
      held.stopped = fmt::format("the controller left the hold, fault {} (docs/faults.md)",
                                 robot.latest().fault);
      return held;
    }
    if (HeldPose pose; mean_of(held.seen, ticks, settings, pose)) held.poses.push_back(pose);
    if (tilt_of(robot.latest().x) > settings.lean_limit_rad) {
      held.stopped = fmt::format("the trunk leans by {:.2f} rad", tilt_of(robot.latest().x));
      return held;
    }
  }
  return held;
}

BringUpModel begin_with(const HeldPoses& held, const BringUpSettings& settings,
                        ModelLearner& learner) {
  BringUpModel out;
  if (held.poses.empty()) return out;
  // standing is explained with the joints' zeros, whether the planner's model has them or not
  const ParameterMap map = learner.parameters().with({});
  const StaticBalance balance = balance_of(held.poses, map, settings.balance);
  const std::vector<PredictionWindow> windows =
      cut_windows_of(held.seen, 0, kUprightTilt_rad, kTicksPerStep);
  out.start = learner.begin_at(balance.z(learner.parameters()), windows);
  out.damping = learner.begin_damped(windows, settings.moves);
  if (settings.refine) out.loss_refined = learner.begin_refined(windows);
  out.friction_Nm = balance.friction_Nm;
  out.figures = figures_of(balance, map, settings.balance);
  return out;
}

void write_bring_up(const std::filesystem::path& path, const HeldPoses& held,
                    const BringUpModel& model) {
  nlohmann::ordered_json out{{"poses", held.poses.size()},
                             {"stopped", held.stopped},
                             {"used", model.start.used},
                             {"loss", model.start.loss},
                             {"loss_initial", model.start.loss_initial},
                             {"loss_refined", nullptr},
                             {"damping_prior_deviations", nullptr},
                             {"friction_Nm", model.friction_Nm}};
  if (model.loss_refined) out["loss_refined"] = *model.loss_refined;
  if (model.damping) out["damping_prior_deviations"] = *model.damping;
  for (const StaticFigure& f : model.figures)
    out["figures"].push_back({{"name", f.name},
                              {"unit", f.unit},
                              {"value", f.value},
                              {"deviation", f.deviation},
                              {"prior_value", f.prior_value},
                              {"prior_deviation", f.prior_deviation},
                              {"seen", f.seen()}});
  files::write_atomically(path, out.dump(1) + "\n");
}

}  // namespace sanso::learn
