// What one simulation reads of model and recording, as plain numbers and pointers: every
// instruction set's copy of the simulation (window_run.h) works on it.
#pragma once

#include <cstddef>

#include "tools/diagnose/sim/command_path.h"
#include "tools/diagnose/sim/lane_state.h"
#include "tools/diagnose/sim/sim_params.h"
#include "tools/diagnose/sim/tree_figures.h"

namespace sanso::diagnose {

struct SimFigures {
  const SimParams* params = nullptr;
  const CommandPath* commands = nullptr;
  const JointParams* joints = nullptr;  // n
  std::size_t n = 0;
  TreeFigures tree;
  // what is simulated, in order
  std::size_t joint_count = 0, branch_count = 0;
  std::size_t simulated[kMaxJoints], branch[kMaxJoints];
  const double* t = nullptr;  // s, of the recording's rows
  std::size_t rows = 0;
  double max_step = 1e-3;  // s
  // by joint; no series: no command
  const double* series[kMaxJoints];
  double command_delay[kMaxJoints], sensor_delay[kMaxJoints];  // s
  double longest_sensor_delay = 0.0;                           // s
  const double* temperature[kMaxJoints];
  double first_temperature[kMaxJoints];  // NaN: none recorded
  bool sags = false, heats = false, late_payloads = false, forces = false;
};

/// `wanted`: by joint, not 0: its branch is simulated; empty: all. A supply that sags couples all
/// joints. Valid as long as its arguments.
SimFigures sim_figures(const SimParams& params, const Drive& drive, const CommandPath& commands,
                       double max_step_s, const std::vector<char>& wanted);

/// Row of the recording that holds at t, s.
std::size_t row_at(const SimFigures& figures, double t);
/// How many late payloads are on at t, and the bodies with them.
std::size_t payloads_on(const SimFigures& figures, double t);
/// `bodies`: room for all joints' links.
void bodies_at(const SimFigures& figures, double t, BodyFigures* bodies);
/// The first instant after t at which a payload comes or a force begins or ends, s.
double next_change(const SimFigures& figures, double t);
/// The forces at t, by joint, N.
void forces_at(const SimFigures& figures, double t, double (*forces)[3]);
/// The command of joint j that acts during [from, until]; see CommandPath.
CommandOf<double> command_over(const SimFigures& figures, std::size_t j, double from, double until,
                               std::size_t& cursor);

/// Rows [first, last] of one window, its start, and where its prediction goes: n x rows each, volt
/// rows. All are given; entries of joints that are not simulated are not written.
struct WindowFigures {
  std::size_t first = 0, last = 0;
  double q[kMaxJoints], dq[kMaxJoints];         // rad, rad/s, of the links, when the window starts
  const InnerStateOf<double>* inner = nullptr;  // n
  double* out_q = nullptr;
  double* out_dq = nullptr;
  double* out_tau = nullptr;
  double* out_i = nullptr;
  double* out_pwm = nullptr;
  double* out_volt = nullptr;
};

/// Where torques go, N m (A, duty), n x rows each.
struct TorqueRows {
  double *motor = nullptr, *friction = nullptr, *passive = nullptr, *current = nullptr,
         *duty = nullptr;
};

/// One recording to follow, and where its inner states go: n for each of `wanted`, rows in
/// ascending order.
struct FollowFigures {
  const SimFigures* figures = nullptr;
  const double* q[kMaxJoints];      // by joint and row, rad: the motion, as its sensors show it
  const double* dq[kMaxJoints];     // rad/s
  std::size_t first = 0, last = 0;  // rows from and to which it is followed
  const std::size_t* wanted = nullptr;
  std::size_t wanted_count = 0;
  InnerStateOf<double>* out = nullptr;
  TorqueRows torques;  // while it is replayed
};

/// The joints whose servo, and where `gears` transmission, is followed.
struct FollowedJoints {
  std::size_t joint[kMaxJoints];
  std::size_t count = 0;
  bool gears = false;
};

}  // namespace sanso::diagnose
