// A controller on an InstantBus, in a trial with all three layers full: what `bench tick` times and
// the test of "no allocation, no page fault" runs.
#pragma once

#include <memory>

#include "firmware/app/controller.h"
#include "tools/bench/instant_bus.h"

namespace sanso::bench {

/// Virtual time, real CPU time.
class RigClock : public board::Clock {
 public:
  Nanoseconds now() override { return now_; }
  Nanoseconds thread_cpu() override;
  void set(Nanoseconds now) { now_ = now; }

 private:
  Nanoseconds now_ = 0;
};

class TickRig {
 public:
  TickRig();
  /// Boots, arms and starts a trial that never ends, with a full middle table. False: it did not
  /// get there.
  bool start_trial();
  /// One tick, with an IMU sample and, every sixth, a policy of four knots. Returns the tick's own
  /// CPU time [ns]: what the servos' emulation takes is left out.
  Nanoseconds tick();
  const firmware::Controller& controller() const { return *controller_; }
  InstantBus& bus() { return bus_; }
  firmware::Handover& handover() { return *handover_; }

 private:
  void publish_imu();
  void publish_policy();

  InstantBus bus_;
  RigClock clock_;
  std::unique_ptr<firmware::Handover> handover_;
  std::unique_ptr<firmware::Controller> controller_;
  Nanoseconds now_ = 0;
  std::uint32_t imu_sequence_ = 0;
  std::uint32_t policy_sequence_ = 0;
};

}  // namespace sanso::bench
