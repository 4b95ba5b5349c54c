// Builds the robot of a trial from its seed, waits until its controller is idle, and adds the
// recorded truth to the episode.
#include "tools/inprocess/inprocess_access.h"

#include <algorithm>
#include <stdexcept>

#include "tools/inprocess/truth_frame.h"

namespace sanso::inprocess {
namespace {

constexpr std::size_t kConditionSize = 20 + 1;  // temperatures, charge

}  // namespace

firmware::Settings settings_on(bool wheels, const std::string& ground, double target_rate_rad_s) {
  firmware::Settings settings;
  if (target_rate_rad_s > 0.0) settings.guard.max_target_rate_rad_s = target_rate_rad_s;
  settings.estimator.wheels = wheels;
  if (wheels) settings.estimator.flat_ground = ground == "plane";
  return settings;
}

InProcessAccess::InProcessAccess(const std::string& world, const firmware::Settings& settings)
    : world_(plant::load_world(world)), settings_(settings), key_(wire::random_key()) {}

link::RobotLink& InProcessAccess::place(const model::State& x, std::uint64_t seed) {
  link_.reset();  // before the robot it talks to
  robot_ = std::make_unique<InProcessRobot>(world_, seed, key_, settings_);
  std::array<double, model::kNumJoints> legs{};
  for (int j = 0; j < model::kNumJoints; ++j)
    legs[static_cast<std::size_t>(j)] = x[model::kXJoint + j];
  robot_->robot().place(emulator::with_legs(legs));
  if (plant::Condition before; world_.tires() && condition_.size() == kConditionSize) {
    std::copy_n(condition_.begin(), before.temperature_C.size(), before.temperature_C.begin());
    before.used_Ah = condition_.back();
    robot_->robot().begin_rested(before);
  }
  if (push_) {
    robot_->robot().lend_hand({push_->push_m_s, push_->push_s});
    if (push_->hold > 0.0) robot_->hold_on_the_way(push_->hold, world_.ground.profile);
  }
  if (prepare_) prepare_(*robot_);
  link_ = std::make_unique<link::RobotLink>(*robot_, *robot_, key_);
  if (link_->open() != Status::ok)
    throw std::runtime_error("the in-process controller does not answer");
  constexpr double kSelfTest_s = 10.0;
  const Nanoseconds give_up = robot_->now() + from_seconds(kSelfTest_s);
  while (link_->latest().state != wire::SupervisorState::idle) {
    if (link_->latest().state == wire::SupervisorState::fault || robot_->now() >= give_up)
      throw std::runtime_error("the in-process controller did not pass its self-test: fault " +
                               std::to_string(link_->latest().fault) + " (docs/faults.md), servo " +
                               std::to_string(robot_->controller().fault_detail()));
    link_->wait_observation(give_up);
  }
  return *link_;
}

std::vector<double> InProcessAccess::condition() const {
  if (!robot_ || !world_.tires()) return {};
  const plant::Condition now = robot_->robot().condition();
  std::vector<double> values(now.temperature_C.begin(), now.temperature_C.end());
  values.push_back(now.used_Ah);
  return values;
}

void InProcessAccess::add_measurements(learn::Episode& episode) {
  const auto& seen = robot_->trial_truth();
  if (episode.ticks.empty() || seen.empty()) return;
  const TruthFrame frame(seen.front().truth.leg_state(), episode.reference.front());
  std::size_t k = 0;
  for (const wire::Observation& o : episode.ticks) {  // both ascend in trial_tick
    while (k + 1 < seen.size() && seen[k].trial_tick < o.trial_tick) ++k;
    const emulator::Truth& truth = seen[k].truth;
    episode.truth.push_back(frame.sample(
        truth.leg_state(), {truth.foot_force_in_world[0][2], truth.foot_force_in_world[1][2]},
        truth.foot_clearance_m));
  }
}

std::unique_ptr<InProcessAccess> access_for(const app::LearnOptions& options) {
  return std::make_unique<InProcessAccess>(
      options.world, settings_on(options.wheels, options.ground, options.target_rate_rad_s));
}

}  // namespace sanso::inprocess
