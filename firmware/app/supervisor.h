// What the robot is doing, and what may come next. All transitions stand in one table; everything
// that is not in it is refused. A fault latches from any state.
#pragma once

#include <array>

#include "firmware/exchange/faults.h"
#include "shared/wire/messages.h"

namespace sanso::firmware {

using wire::SupervisorState;

enum class Event : std::uint8_t {
  // commands
  arm,
  start_trial,
  stop,
  disarm,
  clear_fault,
  lower,
  // what happens by itself
  powered,     // the program runs
  setup_done,  // all servos there, registers set, IMU alive
  adopted,     // the same, and the servos were found holding the robot
  not_armed,   // goals or torque could not be confirmed
  arrived,     // a slow motion has reached its pose
  lowered,     // the robot is down: torque may go
  trial_over,  // duration reached or host silent
  left_alone,  // no host for long, or the program is to end
};

constexpr const char* name_of(SupervisorState state) {
  constexpr std::array kNames{"boot", "self_test", "idle",      "stand_up",
                              "hold", "run",       "soft_stop", "fault"};
  return kNames[static_cast<std::size_t>(state)];
}
constexpr const char* name_of(Event event) {
  constexpr std::array kNames{"arm",     "start_trial", "stop",       "disarm",    "clear_fault",
                              "lower",   "powered",     "setup_done", "adopted",   "not_armed",
                              "arrived", "lowered",     "trial_over", "left_alone"};
  return kNames[static_cast<std::size_t>(event)];
}

struct Transition {
  SupervisorState from;
  Event event;
  SupervisorState to;
};

inline constexpr std::array kTransitions{
    Transition{SupervisorState::boot, Event::powered, SupervisorState::self_test},
    Transition{SupervisorState::self_test, Event::setup_done, SupervisorState::idle},
    Transition{SupervisorState::self_test, Event::adopted, SupervisorState::hold},
    Transition{SupervisorState::idle, Event::arm, SupervisorState::stand_up},
    Transition{SupervisorState::idle, Event::lower, SupervisorState::idle},
    Transition{SupervisorState::stand_up, Event::not_armed, SupervisorState::idle},
    Transition{SupervisorState::stand_up, Event::arrived, SupervisorState::hold},
    Transition{SupervisorState::stand_up, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::stand_up, Event::lower, SupervisorState::soft_stop},
    Transition{SupervisorState::stand_up, Event::left_alone, SupervisorState::soft_stop},
    Transition{SupervisorState::hold, Event::start_trial, SupervisorState::run},
    Transition{SupervisorState::hold, Event::stop, SupervisorState::hold},
    Transition{SupervisorState::hold, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::hold, Event::lower, SupervisorState::soft_stop},
    Transition{SupervisorState::hold, Event::left_alone, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::stop, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::lower, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::left_alone, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::trial_over, SupervisorState::soft_stop},
    Transition{SupervisorState::soft_stop, Event::arrived, SupervisorState::hold},
    Transition{SupervisorState::soft_stop, Event::lowered, SupervisorState::idle},
    Transition{SupervisorState::soft_stop, Event::stop, SupervisorState::soft_stop},
    Transition{SupervisorState::soft_stop, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::soft_stop, Event::lower, SupervisorState::soft_stop},
    Transition{SupervisorState::soft_stop, Event::left_alone, SupervisorState::soft_stop},
    Transition{SupervisorState::fault, Event::lower, SupervisorState::fault},
    Transition{SupervisorState::fault, Event::clear_fault, SupervisorState::self_test},
};

class Supervisor {
 public:
  SupervisorState state() const { return state_; }
  /// What latched, with its detail (faults.h); none while nothing did.
  Fault fault() const { return fault_; }
  std::uint16_t fault_detail() const { return detail_; }

  /// Whether the table has a way from here.
  bool allows(Event event) const { return find(event) != nullptr; }
  /// Goes where the table says; false (and unchanged) when it says nothing.
  bool apply(Event event) {
    const Transition* t = find(event);
    if (t == nullptr) return false;
    state_ = t->to;
    if (state_ != SupervisorState::fault) fault_ = Fault::none;
    return true;
  }
  /// Latches the first fault; later ones change nothing until it is cleared, but for a person's
  /// emergency stop.
  void raise(Fault fault, std::uint16_t detail) {
    if (fault == Fault::none) return;
    if (state_ == SupervisorState::fault && fault != Fault::emergency_stop) return;
    state_ = SupervisorState::fault;
    fault_ = fault;
    detail_ = detail;
  }
  /// Torque is on and the robot is meant to be on its feet.
  bool standing() const {
    return state_ == SupervisorState::stand_up || state_ == SupervisorState::hold ||
           state_ == SupervisorState::run || state_ == SupervisorState::soft_stop;
  }

 private:
  const Transition* find(Event event) const {
    for (const Transition& t : kTransitions)
      if (t.from == state_ && t.event == event) return &t;
    return nullptr;
  }
  SupervisorState state_ = SupervisorState::boot;
  Fault fault_ = Fault::none;
  std::uint16_t detail_ = 0;
};

}  // namespace sanso::firmware
