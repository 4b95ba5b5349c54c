// The 10 ms tick. It reads the bus and the newest samples of the other threads, estimates the
// state, adds up the three layers, guards the sum and sends it. Part of the real-time library: no
// heap, no exceptions, nothing that waits except for servo replies, and for those only until their
// deadline.
#pragma once

#include "firmware/app/posture.h"
#include "firmware/app/supervisor.h"
#include "firmware/app/trial.h"
#include "firmware/board/board.h"
#include "firmware/bus/bus_master.h"
#include "firmware/bus/bus_setup.h"
#include "firmware/config/settings.h"
#include "firmware/estimate/estimator.h"
#include "firmware/exchange/handover.h"
#include "firmware/guard/guard.h"
#include "firmware/imu/board_imu.h"

namespace sanso::firmware {

class Controller {
 public:
  Controller(const Settings& settings, board::SerialPort& port, board::Clock& clock,
             Handover& handover);

  /// One tick. `now` is the time at which it was due, on the board's clock. Call it every 10 ms; it
  /// returns after the goals are on their way (about 2 ms of bus time later).
  void tick(Nanoseconds now);

  /// What the last tick published.
  const wire::Observation& observation() const { return observation_; }
  wire::SupervisorState state() const { return supervisor_.state(); }
  Fault fault() const { return supervisor_.fault(); }
  /// Servo id, or another number that docs/faults.md explains, of the latched fault.
  std::uint16_t fault_detail() const { return supervisor_.fault_detail(); }
  const BusCounters& bus_counters() const { return bus_.counters(); }

 private:
  // requests
  void take_requests();
  Refusal execute(const wire::Command& command);
  Refusal arm(const wire::Command& command);
  Refusal start_trial(const wire::Command& command);
  Refusal stop();
  Refusal disarm();
  Refusal clear_fault();
  void end_trial();
  // sensors, judgement
  void note_lateness(Nanoseconds now);
  bool bus_in_use() const;
  void read_sensors(Nanoseconds now);
  void judge(Nanoseconds now);
  void enter_fault(Fault fault, std::uint16_t detail);
  // state
  void advance_state(Nanoseconds now);
  void self_test(Nanoseconds now);
  bool host_silent(Nanoseconds now) const;
  // output
  model::Input choose_target();
  void command_servos(const model::Input& wanted);
  void arm_step();
  void write_goals(const model::Input& legs);
  void switch_torque(bool on);
  void react_to_fault();
  // report
  void publish(Nanoseconds now, Nanoseconds cpu_begin);
  void report_supply(wire::Observation& o) const;
  void report_layers(Nanoseconds now, wire::Observation& o);

  Settings settings_;
  board::Clock& clock_;
  Handover& handover_;

  BusMaster bus_;
  BusSetup setup_;
  Estimator estimator_;
  Guard guard_;
  BoardImu board_imu_;
  Supervisor supervisor_;
  Trial trial_;
  Posture posture_;

  ServoReadings servos_;
  model::State x_ = model::neutral_state();
  GuardVerdict verdict_;
  policy::LayerOutputs layers_;
  model::Input output_ = model::Input::Zero();  // what was sent last
  wire::Observation observation_;
  LogRecord record_;

  bool start_pending_ = false;  // a start was accepted in this tick
  int arming_tick_ = -1;        // 0..2 while torque is being switched on
  int torque_ticks_ = 0;        // ticks since torque on; 0: off
  int limp_writes_ = 0;
  int slow_read_tick_ = 0;
  Nanoseconds self_test_begin_ = 0;
  Nanoseconds previous_due_ = 0;
  std::uint32_t late_ticks_ = 0;
  int late_in_a_row_ = 0;
};

}  // namespace sanso::firmware
