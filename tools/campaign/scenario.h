// A scenario of the fault campaign: what goes wrong, at which device, in which direction, during
// which motion, and what the controller has to do about it. The list is generated: fault words
// times devices times directions (cells.cpp) times motions, and what can come in the way of arming
// (arming_cells.cpp).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/exchange/faults.h"
#include "tools/emulator/fault_plan.h"
#include "tools/inprocess/simulated_board.h"

namespace sanso::campaign {

/// How a device can fail: the seven words of PX4's failure injection.
enum class Word : std::uint8_t { off, stuck, garbage, wrong, slow, delayed, intermittent };
/// Which way the bytes were going that it happens to.
enum class Direction : std::uint8_t { none, request, reply };
enum class Motion : std::uint8_t { stand, squat, walk, arming };
/// Those that every cell runs in; arming has rows of its own.
inline constexpr std::array kMotions{Motion::stand, Motion::squat, Motion::walk};

/// How a scenario may end for the robot.
enum class Ending : std::uint8_t {
  completes,  // no fault, on its feet in hold
  held,       // a fault is latched, the servos hold it up
  lowered,    // down in the crouch without having fallen, then torque off
  limp,       // torque off without having been lowered
  fell,       // fell, and torque is still on: never right while servos can be talked to
  refused,    // did not get as far as torque: refused with a number
};

/// What happens beyond the emulator's own fault switches.
enum class Act : std::uint8_t {
  none,
  pull_bus,
  lose_host,
  emergency_stop,
  turn_imu,  // from the beginning: the sensor is mounted another way than the settings say
  arm_early  // the arm command comes soon after idle, with a packet spoiled or with none
};

/// How a robot is armed: how soon, and what happens to one packet on the bus.
struct ArmTrouble {
  int ticks_after_idle = 5;
  bool after_clear = false;  // idle after a cleared fault, else after the start
  std::optional<inprocess::SimulatedSerialPort::Spoil> spoil;
  int packet = 0;  // the one that is spoiled, 1: the first after the command
};

/// What is made to go wrong.
struct Trouble {
  std::optional<emulator::Fault> fault;  // its start and stop count from the beginning of trouble
  Act act = Act::none;
  std::array<double, 4> quat_base_sensor{1, 0, 0, 0};  // Act::turn_imu
  ArmTrouble arm;                                      // Act::arm_early
};

/// What the controller has to make of it.
struct Expected {
  std::vector<firmware::Fault> faults;  // one of these latches; empty: none
  std::vector<Ending> endings;          // one of these
  double within_s = 0;                  // from the beginning of trouble to the fault
  bool fall_allowed = false;            // no controller could keep it up
  double max_speed_rad_s = 0;  // of any joint in the half second after torque; 0: not asked
};

struct Scenario {
  Word word{};
  std::string device;  // "bus", "servo 14", "imu", "supply", "pose", "host", "person"
  Direction direction{};
  std::string what;  // told apart from the others of its word: "zeros for 5 ticks"
  Motion motion{};
  Trouble trouble;
  Expected expected;
  std::string name() const;
};

/// One row of the table from which scenarios are generated: everything but the motion.
struct Cell {
  Word word{};
  std::string device;
  Direction direction{};
  std::string what;
  Trouble trouble;
  Expected calm;  // standing and squatting
  Expected walk;  // in mid-step
};
std::vector<Cell> cells();

/// The rows of arming: each packet of the sequence lost or damaged, each wait after idle.
std::vector<Scenario> arming_scenarios();

/// Every scenario, in the order of the page.
std::vector<Scenario> scenarios();

const char* name_of(Word word);
const char* name_of(Direction direction);
const char* name_of(Motion motion);
const char* name_of(Ending ending);

}  // namespace sanso::campaign
