// What the tests of a session's edges look at and do on the emulated robot.
#pragma once

#include <cmath>

#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware::testing {

inline double torque_sum(const EmulatedController& c) {
  double sum = 0;
  for (const double torque : c.robot.truth().torque) sum += std::abs(torque);
  return sum;
}
inline bool on_its_feet(const EmulatedController& c) {
  const emulator::Truth truth = c.robot.truth();
  return truth.other_contacts == 0 && truth.p_world_base[2] > 0.2;
}
inline void switch_fault(EmulatedController& c, emulator::FaultKind kind, int id = 0,
                         double seconds = 1e3, double amount = 0) {
  emulator::Fault fault;
  fault.kind = kind;
  fault.id = id;
  fault.amount = amount;
  fault.start = c.robot.now();
  fault.stop = fault.start + from_seconds(seconds);
  c.robot.faults().add(fault);
}
}  // namespace sanso::firmware::testing
