#include "tools/inprocess/inprocess_access.h"

#include <stdexcept>

namespace sanso::inprocess {
namespace {

/// From the world's frame to the reference's: the robot stood at the reference's first position and heading when the
/// trial began.
struct Placing {
  math::Quat quat_ref_world = math::quat_identity();
  math::Vec3 p_ref_world = math::Vec3::Zero();

  learn::TrueSample in_reference_frame(const emulator::Truth& truth) const {
    const std::array<double, model::kNx> raw = truth.leg_state();
    learn::TrueSample sample;
    sample.x = Eigen::Map<const model::State>(raw.data());
    const math::Mat3 R_ref_world = math::rotation_matrix(quat_ref_world);
    sample.x.segment<3>(model::kXPos) = p_ref_world + R_ref_world * model::base_position(sample.x);
    sample.x.segment<4>(model::kXQuat) = math::quat_multiply(quat_ref_world, model::base_quat(sample.x));
    sample.x.segment<3>(model::kXVel) = R_ref_world * sample.x.segment<3>(model::kXVel);
    for (std::size_t foot = 0; foot < 2; ++foot) sample.foot_load_N[foot] = static_cast<float>(truth.foot_force_in_world[foot][2]);
    return sample;
  }
};

Placing placing_of(const emulator::Truth& first, const std::array<float, model::kNx>& reference) {
  const std::array<double, model::kNx> raw = first.leg_state();
  const model::State x_world = Eigen::Map<const model::State>(raw.data());
  const model::State x_ref = Eigen::Map<const Eigen::Matrix<float, model::kNx, 1>>(reference.data()).cast<double>();
  Placing placing;
  const double turn = math::yaw_of(model::base_quat(x_ref)) - math::yaw_of(model::base_quat(x_world));
  placing.quat_ref_world = math::quat_exp({0.0, 0.0, turn});
  placing.p_ref_world = model::base_position(x_ref) - math::rotation_matrix(placing.quat_ref_world) * model::base_position(x_world);
  placing.p_ref_world[2] = 0.0;  // heights are absolute
  return placing;
}

}  // namespace

InProcessAccess::InProcessAccess(const std::string& world) : world_(plant::load_world(world)), key_(wire::random_key()) {}

link::RobotLink& InProcessAccess::place(const model::State& x, std::uint64_t seed) {
  link_.reset();  // before the robot it talks to
  robot_ = std::make_unique<InProcessRobot>(world_, seed, key_);
  std::array<double, model::kNumJoints> legs{};
  for (int j = 0; j < model::kNumJoints; ++j) legs[static_cast<std::size_t>(j)] = x[model::kXJoint + j];
  robot_->robot().place(emulator::with_legs(legs));
  link_ = std::make_unique<link::RobotLink>(*robot_, *robot_, key_);
  if (link_->open() != Status::ok) throw std::runtime_error("the in-process controller does not answer");
  constexpr double kSelfTest_s = 10.0;
  const Nanoseconds give_up = robot_->now() + from_seconds(kSelfTest_s);
  while (link_->latest().state != wire::SupervisorState::idle) {
    if (link_->latest().state == wire::SupervisorState::fault || robot_->now() >= give_up)
      throw std::runtime_error("the in-process controller did not pass its self-test: fault " + std::to_string(link_->latest().fault) +
                               " (docs/faults.md), servo " + std::to_string(robot_->controller().fault_detail()));
    link_->wait_observation(give_up);
  }
  return *link_;
}

void InProcessAccess::add_measurements(learn::Episode& episode) {
  const auto& seen = robot_->trial_truth();
  if (episode.ticks.empty() || seen.empty()) return;
  const Placing placing = placing_of(seen.front().truth, episode.reference.front());
  std::size_t k = 0;
  for (const wire::Observation& o : episode.ticks) {  // both ascend in trial_tick
    while (k + 1 < seen.size() && seen[k].trial_tick < o.trial_tick) ++k;
    episode.truth.push_back(placing.in_reference_frame(seen[k].truth));
  }
}

}  // namespace sanso::inprocess
