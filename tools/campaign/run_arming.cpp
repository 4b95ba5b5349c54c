// A robot in a person's hands is armed while something comes in the way. Its legs have been moved
// since its goals were set, so that a goal that does not arrive shows as a limb that runs.
#include <stdexcept>

#include "firmware/app/posture.h"
#include "host/link/robot_link.h"
#include "host/motion/motion.h"
#include "shared/policy/policy_bytes.h"
#include "tools/campaign/run_scenario.h"

namespace sanso::campaign {
namespace {

using wire::CommandKind;
using wire::SupervisorState;

void require(bool done, const char* what) {
  if (!done) throw std::runtime_error(std::string("arming: ") + what);
}

class HeldRobot {
 public:
  explicit HeldRobot(std::uint64_t seed)
      : key_(wire::random_key()), robot_(plant::load_world("lab"), seed, key_) {}

  void hold_in(const model::Input& pose) {
    std::array<double, model::kNumJoints> legs{};
    for (int j = 0; j < model::kNumJoints; ++j) legs[static_cast<std::size_t>(j)] = pose[j];
    robot_.robot().place(emulator::with_legs(legs));
    robot_.robot().hold(true);
  }
  void upload_motion() {
    const motion::Motion motion = motion::MotionLibrary().load("stand");
    std::vector<std::uint8_t> bytes(policy::kMaxPrimitiveBytes);
    bytes.resize(policy::to_bytes(motion.primitives, bytes));
    require(link_.upload(wire::UploadKind::primitives, bytes) == Status::ok, "no upload");
  }
  void live(int ticks) {
    for (; ticks > 0; --ticks) {
      link_.wait_observation(robot_.now() + kSecond);
      link_.send_sign_of_life();
    }
  }
  /// Returns with the first observation of the state.
  void come_to(SupervisorState state) {
    constexpr int kMostTicks = 1500;
    for (int k = 0; link_.latest().state != state; ++k) {
      require(k < kMostTicks, "does not come to idle or hold");
      live(1);
    }
  }

  inprocess::InProcessRobot& robot() { return robot_; }
  link::RobotLink& link() { return link_; }

 private:
  wire::Key key_;
  inprocess::InProcessRobot robot_;
  link::RobotLink link_{robot_, robot_, key_};
};

/// Armed once, stopped by a person, put elsewhere and cleared: its servos have old goals.
void arm_stop_and_clear(HeldRobot& held) {
  require(held.link().command({.kind = CommandKind::arm}) == Status::ok, "not armed at first");
  held.come_to(SupervisorState::hold);
  held.robot().handover().emergency_stop = true;
  held.live(20);
  held.hold_in(firmware::crouch_pose());
  require(held.link().command({.kind = CommandKind::clear_fault}) == Status::ok, "not cleared");
}

}  // namespace

Found run_arming(const Scenario& scenario, std::uint64_t seed) {
  constexpr int kLook = 90;
  const ArmTrouble& arm = scenario.trouble.arm;
  HeldRobot held(seed);
  held.hold_in(firmware::crouch_pose());
  require(held.link().open() == Status::ok, "the controller does not answer");
  held.upload_motion();
  held.come_to(SupervisorState::idle);
  if (arm.after_clear) {
    held.live(5);
    arm_stop_and_clear(held);
    held.come_to(SupervisorState::idle);
  }
  Witness witness(held.robot());
  held.robot().after_tick([&] { witness.look(); });
  held.live(arm.ticks_after_idle);
  if (arm.spoil) held.robot().bus().spoil(*arm.spoil, arm.packet);
  const Status answer = held.link().command({.kind = CommandKind::arm});
  held.live(kLook);
  Found found = witness.found();
  if (answer == Status::rejected) found.refusal = held.link().refusal();
  found.broken = broken_of(scenario.expected, found, "");
  return found;
}

}  // namespace sanso::campaign
