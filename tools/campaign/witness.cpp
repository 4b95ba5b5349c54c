// Falls are judged by the physics: anything but feet on the ground, or a trunk that lies, while the
// robot has not been lowered.
#include "tools/campaign/witness.h"

#include <algorithm>
#include <cmath>

#include "tools/campaign/bounds.h"

namespace sanso::campaign {
namespace {

constexpr double kLow_m = 0.19, kUpright_rad = 0.5;  // down in the crouch, not fallen
constexpr Nanoseconds kAfterTorque = kSecond / 2;
constexpr Nanoseconds kAfterTrouble = 8 * kSecond;  // lowering takes 3 s

double tilt_of(const emulator::Truth& truth) {
  const auto& q = truth.quat_world_base;
  return std::acos(std::clamp(1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]), -1.0, 1.0));
}
/// Of the servos that can be told anything: without the one whose cable is off.
double torque_sum(const emulator::Truth& truth, emulator::FaultPlan& faults) {
  double sum = 0;
  for (int id = 1; id <= emulator::kNumServos; ++id)
    if (faults.active(emulator::FaultKind::servo_silent, id, truth.time) == nullptr)
      sum += std::abs(truth.torque[static_cast<std::size_t>(id - 1)]);
  return sum;
}

}  // namespace

void Witness::look_at_targets() {
  const model::Input target = robot_.controller().observation().u_out;
  // without torque the target is where the joints are: the first step counts too
  if (robot_.controller().torque_on() && looked_)
    found_.step_rad = std::max(found_.step_rad, (target - target_).cwiseAbs().maxCoeff());
  looked_ = true;
  target_ = target;
}

/// As the servos are, not as the controller believes.
void Witness::look_at_torque(const emulator::Truth& truth) {
  const bool torque = torque_sum(truth, robot_.robot().faults()) > 0;
  if (torque && !torque_) torque_since_ = truth.time;
  if (!torque && torque_) torque_off_at_ = truth.time;
  torque_ = torque;
}

void Witness::look_for_fall(const emulator::Truth& truth) {
  if (!torque_ && torque_off_at_ >= 0 && !lowered_ && fell_at_ < 0 &&
      truth.time - torque_off_at_ < 2 * kTickPeriod)
    lowered_ = truth.p_world_base[2] < kLow_m && tilt_of(truth) < kUpright_rad;
  const bool down = truth.other_contacts > 0 || tilt_of(truth) > kLying_rad;
  if (down && !lowered_ && fell_at_ < 0 && torque_since_ >= 0) fell_at_ = truth.time;
  if (fell_at_ >= 0 && truth.time - fell_at_ >= kAfterFall && found_.torque_Nm < 0)
    found_.torque_Nm = torque_sum(truth, robot_.robot().faults());
}

void Witness::look() {
  const emulator::Truth truth = robot_.robot().truth();
  look_at_targets();
  look_at_torque(truth);
  look_for_fall(truth);
  if (torque_ && truth.time - torque_since_ < kAfterTorque)
    for (const double dq : truth.dq)
      found_.speed_rad_s = std::max(found_.speed_rad_s, std::abs(dq));
  if (fault_at_ < 0 && robot_.controller().fault() != firmware::Fault::none) {
    fault_at_ = truth.time;
    found_.fault = robot_.controller().fault();
    found_.detail = robot_.controller().fault_detail();
    if (trouble_at_ != INT64_MAX) found_.reaction_s = to_seconds(fault_at_ - trouble_at_);
  }
}

bool Witness::settled() const {
  const Nanoseconds now = robot_.now();
  if (fell_at_ >= 0) return now - fell_at_ > kAfterFall;
  return trouble_at_ != INT64_MAX && now - trouble_at_ > kAfterTrouble;
}

Found Witness::found() const {
  Found found = found_;
  found.fell = fell_at_ >= 0;
  if (torque_since_ < 0)
    found.ending = Ending::refused;
  else if (!torque_)
    found.ending = lowered_ ? Ending::lowered : Ending::limp;
  else if (found.fell)
    found.ending = Ending::fell;
  else
    found.ending = found.fault == firmware::Fault::none ? Ending::completes : Ending::held;
  return found;
}

}  // namespace sanso::campaign
