// The supervisor's table: what may follow what, and that a fault latches.
#include "firmware/app/supervisor.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "firmware/app/faults_page.h"

namespace sanso::firmware {
namespace {

constexpr std::array kAllStates{SupervisorState::boot,      SupervisorState::self_test,
                                SupervisorState::idle,      SupervisorState::stand_up,
                                SupervisorState::hold,      SupervisorState::run,
                                SupervisorState::soft_stop, SupervisorState::fault};
constexpr std::array kAllEvents{
    Event::arm,     Event::start_trial, Event::stop,       Event::disarm,    Event::clear_fault,
    Event::lower,   Event::powered,     Event::setup_done, Event::adopted,   Event::not_armed,
    Event::arrived, Event::lowered,     Event::trial_over, Event::left_alone};

/// A supervisor brought into a state by the table alone.
Supervisor in_state(SupervisorState wanted) {
  Supervisor s;
  if (wanted == SupervisorState::boot) return s;
  s.apply(Event::powered);
  if (wanted == SupervisorState::self_test) return s;
  if (wanted == SupervisorState::fault) {
    s.raise(Fault::fallen, 7);
    return s;
  }
  s.apply(Event::setup_done);
  if (wanted == SupervisorState::idle) return s;
  s.apply(Event::arm);
  if (wanted == SupervisorState::stand_up) return s;
  s.apply(Event::arrived);
  if (wanted == SupervisorState::hold) return s;
  s.apply(Event::start_trial);
  if (wanted == SupervisorState::run) return s;
  s.apply(Event::stop);
  return s;
}

TEST(Supervisor, EveryEventInEveryStateDoesWhatTheTableSaysAndNothingElse) {
  for (const SupervisorState from : kAllStates) {
    for (const Event event : kAllEvents) {
      Supervisor s = in_state(from);
      ASSERT_EQ(s.state(), from);
      const Transition* row = nullptr;
      for (const Transition& t : kTransitions)
        if (t.from == from && t.event == event) row = &t;
      EXPECT_EQ(s.allows(event), row != nullptr);
      EXPECT_EQ(s.apply(event), row != nullptr);
      EXPECT_EQ(s.state(), row != nullptr ? row->to : from);
    }
  }
}

TEST(Supervisor, OnlyClearingLeavesAFault) {
  for (const Transition& t : kTransitions)
    if (t.from == SupervisorState::fault && t.to != SupervisorState::fault) {
      EXPECT_EQ(t.event, Event::clear_fault);
    }
  for (const SupervisorState from : kAllStates) {
    if (from == SupervisorState::fault) continue;
    Supervisor s = in_state(from);
    s.raise(Fault::bus_silent, 3);
    EXPECT_EQ(s.state(), SupervisorState::fault);
    s.raise(Fault::fallen, 4);  // the first one stays
    EXPECT_EQ(s.fault(), Fault::bus_silent);
    EXPECT_EQ(s.fault_detail(), 3);
    s.apply(Event::lower);
    EXPECT_EQ(s.fault(), Fault::bus_silent) << "lowering leaves it latched";
    s.raise(Fault::emergency_stop, 0);  // but for a person's
    EXPECT_EQ(s.fault(), Fault::emergency_stop);
    s.apply(Event::clear_fault);
    EXPECT_EQ(s.fault(), Fault::none);
  }
}

TEST(Supervisor, ATrialIsReachedOnlyThroughHold) {
  for (const Transition& t : kTransitions)
    if (t.to == SupervisorState::run) {
      EXPECT_EQ(t.from, SupervisorState::hold);
    }
}

std::string faults_page_file() {
  std::ifstream file("docs/faults.md");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(FaultsPage, IsTheOneThatTheCodeMakes) {
  EXPECT_EQ(faults_page_file(), faults_page()) << "make it anew: sanso-faults-page";
}

TEST(FaultsPage, HasWordsForEveryNumber) {
  const std::string page = faults_page();
  for (const FaultInfo& f : kFaults)
    EXPECT_NE(page.find("## F" + std::to_string(static_cast<int>(f.fault)) + " " + f.name + "\n"),
              std::string::npos);
  for (const LimitInfo& l : kLimits)
    EXPECT_NE(page.find("## L" + std::to_string(static_cast<int>(l.limit)) + " " + l.name + "\n"),
              std::string::npos);
  for (const RefusalInfo& r : kRefusals)
    EXPECT_NE(page.find("## R" + std::to_string(static_cast<int>(r.refusal)) + " " + r.name + "\n"),
              std::string::npos);
}

}  // namespace
}  // namespace sanso::firmware
