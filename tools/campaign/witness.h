// What really happens to the robot in a scenario: looked up in the physics and at the controller
// after every tick, by somebody whom neither can see.
#pragma once

#include <vector>

#include "tools/campaign/scenario.h"
#include "tools/inprocess/inprocess_robot.h"

namespace sanso::campaign {

/// What a scenario came to.
struct Found {
  firmware::Fault fault = firmware::Fault::none;
  std::uint16_t detail = 0;
  std::uint16_t refusal = 0;  // of the command that was refused, when one was
  Ending ending = Ending::completes;
  double reaction_s = -1;           // from the beginning of trouble to the fault; -1: no fault
  double step_rad = 0;              // largest change of a target in a tick, torque on
  double speed_rad_s = 0;           // fastest joint in the half second after torque on
  bool fell = false;                // before it was lowered
  double torque_Nm = -1;            // sum over the servos 5 s after the fall; -1: no fall
  int ticks_lost = 0;               // observations of the controller that the host never got
  std::vector<std::string> broken;  // what was expected and is not so
  bool passed() const { return broken.empty(); }
};

class Witness {
 public:
  explicit Witness(inprocess::InProcessRobot& robot) : robot_(robot) {}
  /// After every tick.
  void look();
  /// Trouble begins at this time of the world.
  void trouble_at(Nanoseconds time) { trouble_at_ = time; }
  /// What was seen, ending included.
  Found found() const;
  bool fell() const { return fell_at_ >= 0; }
  /// Nothing more can happen that the campaign asks for.
  bool settled() const;

 private:
  void look_at_targets();
  void look_at_torque(const emulator::Truth& truth);
  void look_for_fall(const emulator::Truth& truth);

  inprocess::InProcessRobot& robot_;
  Found found_;
  Nanoseconds trouble_at_ = INT64_MAX;
  Nanoseconds fault_at_ = -1, fell_at_ = -1, torque_since_ = -1, torque_off_at_ = -1;
  bool torque_ = false, lowered_ = false, looked_ = false;
  model::Input target_ = model::Input::Zero();
};

}  // namespace sanso::campaign
