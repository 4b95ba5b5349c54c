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
  // what happens by itself
  powered,     // the program runs
  setup_done,  // all servos there, registers set, IMU alive
  arrived,     // a slow motion has reached its pose
  lowered,     // the robot is down: torque may go
  trial_over,  // duration reached or host silent
};

struct Transition {
  SupervisorState from;
  Event event;
  SupervisorState to;
};

inline constexpr std::array kTransitions{
    Transition{SupervisorState::boot, Event::powered, SupervisorState::self_test},
    Transition{SupervisorState::self_test, Event::setup_done, SupervisorState::idle},
    Transition{SupervisorState::idle, Event::arm, SupervisorState::stand_up},
    Transition{SupervisorState::stand_up, Event::arrived, SupervisorState::hold},
    Transition{SupervisorState::stand_up, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::hold, Event::start_trial, SupervisorState::run},
    Transition{SupervisorState::hold, Event::stop, SupervisorState::hold},
    Transition{SupervisorState::hold, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::stop, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::run, Event::trial_over, SupervisorState::soft_stop},
    Transition{SupervisorState::soft_stop, Event::arrived, SupervisorState::hold},
    Transition{SupervisorState::soft_stop, Event::lowered, SupervisorState::idle},
    Transition{SupervisorState::soft_stop, Event::stop, SupervisorState::soft_stop},
    Transition{SupervisorState::soft_stop, Event::disarm, SupervisorState::soft_stop},
    Transition{SupervisorState::fault, Event::clear_fault, SupervisorState::self_test},
};

class Supervisor {
 public:
  SupervisorState state() const { return state_; }
  Fault fault() const { return fault_; }
  std::uint16_t fault_detail() const { return detail_; }

  bool allows(Event event) const { return find(event) != nullptr; }
  /// Goes where the table says; false (and unchanged) when it says nothing.
  bool apply(Event event) {
    const Transition* t = find(event);
    if (t == nullptr) return false;
    if (state_ == SupervisorState::fault) fault_ = Fault::none;
    state_ = t->to;
    return true;
  }
  /// Latches the first fault; later ones change nothing until it is cleared.
  void raise(Fault fault, std::uint16_t detail) {
    if (state_ == SupervisorState::fault || fault == Fault::none) return;
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
