// What can come in the way of arming: the command right after idle, and any one packet of the
// sequence lost or damaged, on its way to the servos or back.
#include "tools/campaign/scenario.h"

namespace sanso::campaign {
namespace {

using Spoil = inprocess::SimulatedSerialPort::Spoil;

constexpr int kMostTicks = 10, kPackets = 24;

Scenario row(Word word, Direction direction, const std::string& what, const ArmTrouble& arm) {
  // armed, or refused with a number; a person holds the robot
  Expected calm{{}, {Ending::completes, Ending::refused, Ending::limp}, 0, false, 1.5};
  Trouble trouble;
  trouble.act = Act::arm_early;
  trouble.arm = arm;
  return {word, "bus", direction, what, Motion::arming, trouble, calm};
}

}  // namespace

std::vector<Scenario> arming_scenarios() {
  std::vector<Scenario> all;
  for (const bool after_clear : {false, true})
    for (int ticks = 0; ticks <= kMostTicks; ++ticks) {
      ArmTrouble arm;
      arm.ticks_after_idle = ticks;
      arm.after_clear = after_clear;
      const std::string what = std::to_string(ticks) + " ticks after " +
                               (after_clear ? "idle that follows a clear" : "idle");
      Scenario early = row(Word::slow, Direction::none, what, arm);
      early.device = "host";
      early.expected.endings = {Ending::completes};  // nothing is broken
      all.push_back(early);
    }
  const struct {
    Spoil spoil;
    Word word;
    Direction direction;
    const char* what;
  } kSpoils[] = {{Spoil::lose_request, Word::off, Direction::request, "lost"},
                 {Spoil::damage_request, Word::garbage, Direction::request, "damaged"},
                 {Spoil::lose_reply, Word::off, Direction::reply, "lost"},
                 {Spoil::damage_reply, Word::garbage, Direction::reply, "damaged"}};
  for (const auto& spoil : kSpoils)
    for (int packet = 1; packet <= kPackets; ++packet) {
      ArmTrouble arm;
      arm.after_clear = true;  // old goals are elsewhere: a lost goal is a limb that runs back
      arm.spoil = spoil.spoil;
      arm.packet = packet;
      all.push_back(row(spoil.word, spoil.direction,
                        "packet " + std::to_string(packet) + " " + spoil.what, arm));
    }
  return all;
}

}  // namespace sanso::campaign
