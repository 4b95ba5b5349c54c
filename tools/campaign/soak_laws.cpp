// Each law counts how often it was broken; the first is as bad as the thousandth.
#include "tools/campaign/soak_laws.h"

#include <algorithm>
#include <cmath>

#include "tools/campaign/bounds.h"

namespace sanso::campaign {
namespace {

using wire::SupervisorState;

/// One tick may take two steps of the table: what was asked, and what follows by itself.
bool legal(SupervisorState from, SupervisorState to) {
  if (from == to || to == SupervisorState::fault) return true;
  const auto leads = [](SupervisorState a, SupervisorState b) {
    return std::any_of(firmware::kTransitions.begin(), firmware::kTransitions.end(),
                       [&](const firmware::Transition& t) { return t.from == a && t.to == b; });
  };
  if (leads(from, to)) return true;
  return std::any_of(
      firmware::kTransitions.begin(), firmware::kTransitions.end(),
      [&](const firmware::Transition& t) { return t.from == from && leads(t.to, to); });
}

}  // namespace

void SoakLaws::look(inprocess::InProcessRobot& robot, bool faults_active) {
  ++ticks_;
  look_at_state(robot.controller());
  look_at_targets(robot.controller());
  look_at_body(robot.robot().truth(), faults_active);
  fresh_ = false;
}

void SoakLaws::look_at_state(const firmware::Controller& controller) {
  const SupervisorState state = controller.state();
  const firmware::Fault fault = controller.fault();
  if (!fresh_ && !legal(state_, state))
    broken(std::string("state ") + firmware::name_of(state_) + " -> " + firmware::name_of(state));
  const bool latched = !fresh_ && state_ == SupervisorState::fault &&
                       state == SupervisorState::fault && fault != fault_;
  if (latched && fault != firmware::Fault::emergency_stop)
    broken(std::string("latched fault ") + name_of(fault_) + " became " + name_of(fault));
  if ((fault != firmware::Fault::none) != (state == SupervisorState::fault))
    broken("a fault without its state, or the state without a fault");
  if (fault != firmware::Fault::none && (fresh_ || fault != fault_))
    ++faults_[static_cast<int>(fault)];
  state_ = state;
  fault_ = fault;
}

void SoakLaws::look_at_targets(const firmware::Controller& controller) {
  const wire::Observation& o = controller.observation();
  if (!o.u_out.allFinite() || !o.x.allFinite()) broken("a number that is none");
  if (!fresh_ && torque_ && controller.torque_on()) {
    const double step = (o.u_out - target_).cwiseAbs().maxCoeff();
    largest_step_rad_ = std::max(largest_step_rad_, step);
    if (step > kMaxStep_rad) broken("a target that jumps");
  }
  torque_ = controller.torque_on();
  target_ = o.u_out;
}

void SoakLaws::look_at_body(const emulator::Truth& truth, bool faults_active) {
  const auto& q = truth.quat_world_base;
  const double tilt = std::acos(std::clamp(1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]), -1.0, 1.0));
  const bool down = tilt > kLying_rad;
  if (down && !down_) ++falls_;
  down_ = down;
  // while devices are broken the order may not get through; after that it has its five seconds
  if (!down || faults_active || fresh_) down_since_ = truth.time;
  double torque = 0;
  for (const double t : truth.torque) torque += std::abs(t);
  if (down && torque > 0 && truth.time - down_since_ > kAfterFall)
    broken("torque five seconds after a fall");
}

}  // namespace sanso::campaign
