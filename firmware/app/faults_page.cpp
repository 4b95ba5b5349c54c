// Walks the tables; the words are in faults_words.h.
#include "firmware/app/faults_page.h"

#include <sstream>

#include "firmware/app/faults_words.h"
#include "firmware/app/supervisor.h"

namespace sanso::firmware {
namespace {

constexpr const char* kHead =
    R"(# Faults, limits, refusals

Made from the code by `sanso-faults-page`; a test compares.

Broken and limited are different words. A **fault** latches: what the robot was doing ends, the
number stays until `clear_fault`, and the flight recorder writes the minute before it and half a
second after. A **limit** informs: the tick that it concerns is marked in `Observation::limits`,
the robot carries on. A **refusal** answers a command or an upload.

What the servos do at a fault:
*hold*: torque stays as it is and the last safe target is sent every tick. When nothing can be
sent (F10, F12) the servos hold their last goal by themselves: their own bus watchdog is left
off on purpose, because a standing robot that is let go falls.
*lower*: the robot goes down into the crouch, then torque off.
*limp*: torque off, said until every servo has confirmed it.
Whatever is latched, a robot that falls goes limp, one that must not go on standing (heat,
supply, no IMU) or that no host has talked to for `supervisor.left_alone_s` is lowered, and the
command `lower` brings it down. `clear_fault` never lets a robot fall: it is refused (R105)
while the servos hold it.

A `detail` says which servo or how much.
)";

std::string number(char kind, int value) { return kind + std::to_string(value); }

const char* words(FaultReaction reaction) {
  switch (reaction) {
    case FaultReaction::hold:
      return "hold";
    case FaultReaction::lower:
      return "lower";
    case FaultReaction::limp:
      break;
  }
  return "limp";
}

}  // namespace

std::string faults_page() {
  std::ostringstream page;
  page << kHead << "\n# Faults\n";
  for (const FaultInfo& info : kFaults)
    for (const FaultWords& text : kFaultWords)
      if (text.fault == info.fault)
        page << "\n## " << number('F', static_cast<int>(info.fault)) << " " << info.name << "\n\n"
             << text.meaning << " Reaction: " << words(info.reaction)
             << ".\nLook at: " << text.look_at << "\n";
  page << "\n# Limits\n\nThe number is the bit in `Observation::limits`.\n";
  for (const LimitInfo& info : kLimits)
    for (const LimitWords& text : kLimitWords)
      if (text.limit == info.limit)
        page << "\n## " << number('L', static_cast<int>(info.limit)) << " " << info.name << "\n\n"
             << text.meaning << "\n";
  page << "\n# Refusals\n";
  for (const RefusalInfo& info : kRefusals)
    for (const RefusalWords& text : kRefusalWords)
      if (text.refusal == info.refusal)
        page << "\n## " << number('R', static_cast<int>(info.refusal)) << " " << info.name << "\n\n"
             << text.meaning << "\n";
  page << "\n# States\n\nWhat is not in this table is refused (R100); a fault latches from any "
          "state.\n\n| state | event | next |\n|---|---|---|\n";
  for (const Transition& t : kTransitions)
    page << "| " << name_of(t.from) << " | " << name_of(t.event) << " | " << name_of(t.to)
         << " |\n";
  return page.str();
}

}  // namespace sanso::firmware
