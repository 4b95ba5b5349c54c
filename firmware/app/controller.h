// The 10 ms tick. It reads the bus and the newest samples of the other threads, estimates the
// state, adds up the three layers, guards the sum and sends it. Part of the real-time library: no
// heap, no exceptions, nothing that waits except for servo replies, and for those only until their
// deadline. The work is spread over controller.cpp (sensors, judgement, states), requests.cpp (what
// hosts and people ask), output.cpp (what goes to the servos) and report.cpp (what is published).
#pragma once

#include "firmware/app/arming.h"
#include "firmware/app/posture.h"
#include "firmware/app/supervisor.h"
#include "firmware/app/trial.h"
#include "firmware/board/board.h"
#include "firmware/bus/bus_master.h"
#include "firmware/bus/bus_setup.h"
#include "firmware/config/settings.h"
#include "firmware/estimate/estimator.h"
#include "firmware/estimate/imu_watch.h"
#include "firmware/exchange/handover.h"
#include "firmware/guard/guard.h"
#include "firmware/imu/board_imu.h"
#include "shared/base/realtime.h"

namespace sanso::firmware {

class Controller {
 public:
  Controller(const Settings& settings, board::SerialPort& port, board::Clock& clock,
             Handover& handover);

  /// One tick. `now` is the time at which it was due, on the board's clock. Call it every 10 ms; it
  /// returns after the goals are on their way (about 2 ms of bus time later).
  void tick(Nanoseconds now) SANSO_REALTIME;

  /// What the last tick published.
  const wire::Observation& observation() const { return observation_; }
  wire::SupervisorState state() const { return supervisor_.state(); }
  Fault fault() const { return supervisor_.fault(); }
  /// Servo id, or another number that docs/faults.md explains, of the latched fault.
  std::uint16_t fault_detail() const { return supervisor_.fault_detail(); }
  /// Torque is on, or was not yet confirmed to be off.
  bool torque_on() const { return torque_ != Torque::off; }

 private:
  enum class Torque : std::uint8_t { off, on, releasing };
  /// What is done with the servos while a fault is latched and torque is on.
  enum class FaultPhase : std::uint8_t { hold, lower, tuck };

  // requests
  void take_requests(Nanoseconds now);
  Refusal execute(const wire::Command& command);
  void acknowledge(std::uint32_t sequence, Refusal refusal);
  void take_emergency();
  void take_buttons(std::uint8_t down);
  void take_end_request(Nanoseconds now);
  Refusal arm(const wire::Command& command);
  void try_to_arm(Nanoseconds now);
  Refusal arming_gate(Nanoseconds now) const;
  void end_arming(Refusal refusal);
  Refusal start_trial(const wire::Command& command);
  Refusal stop();
  Refusal disarm(Event event);
  Refusal lower_in_fault();
  Refusal clear_fault();
  void end_trial();
  // sensors, judgement
  void note_lateness(Nanoseconds now);
  bool bus_in_use() const;
  void read_sensors(Nanoseconds now);
  void judge(Nanoseconds now);
  void escalate(const GuardVerdict& verdict);
  void enter_fault(Fault fault, std::uint16_t detail);
  // state
  void advance_state(Nanoseconds now);
  void self_test(Nanoseconds now);
  void adopt();
  bool host_silent(Nanoseconds now) const;
  bool left_alone(Nanoseconds now) const;
  // output
  model::Input choose_target();
  model::Input joints_now() const;
  void command_servos(const model::Input& wanted);
  void arm_step();
  void write_goals(const model::Input& legs);
  void write_duties();
  void begin_release();
  void release_step();
  bool release_in_silence() const;
  void react_to_fault(const model::Input& wanted);
  void begin_fault_phase(FaultPhase phase);
  ServoGoals goals_of(const std::array<std::int32_t, kNumServos>& raw) const;
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
  ImuWatch imu_watch_;
  Guard guard_;
  BoardImu board_imu_;
  Supervisor supervisor_;
  Trial trial_;
  Posture posture_;
  Arming arming_;

  ServoReadings servos_;
  model::State x_ = model::neutral_state();
  GuardVerdict verdict_;
  policy::LayerOutputs layers_;
  model::Input output_ = model::Input::Zero();  // what was sent last
  std::array<double, kNumHeld> held_output_{};  // the same for arms and head
  bool output_known_ = false;                   // the two are what the servos have
  wire::Observation observation_;
  LogRecord record_;

  bool start_pending_ = false;  // a start was accepted in this tick
  wire::Command arm_command_;   // the one under way
  int arm_wait_ticks_ = -1;     // ticks that it has waited for the gate; -1: none waits
  int fresh_ticks_ = 0;         // ticks in a row in which all servos have answered
  bool imu_new_ = false;        // a sample came since the last tick
  std::uint8_t buttons_ = 0;    // of the OpenCR board, as they were in the last tick

  Torque torque_ = Torque::off;
  int torque_ticks_ = 0;  // ticks since torque on
  Nanoseconds torque_since_ = 0;
  int release_tries_ = 0;
  Arming::Duties duties_raw_{};  // Goal PWM sent last
  int duty_age_ticks_ = 0;
  FaultPhase fault_phase_ = FaultPhase::hold;
  bool ending_ = false;
  Nanoseconds ending_since_ = 0;

  unsigned slow_read_tick_ = 0;
  std::uint32_t foreign_seen_ = 0;
  Nanoseconds self_test_begin_ = 0;
  Nanoseconds previous_due_ = 0;
  std::uint32_t late_ticks_ = 0;
  bool late_ = false;
};

}  // namespace sanso::firmware
