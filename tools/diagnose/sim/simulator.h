// The simulator with switches: a fixed-base robot, its actuators and every effect of the library at
// its port.
//
//   command -> [delay, hold, loss] -> [profile, P I D, dead zone, filter] -> [supply, winding,
//   limits] -> motor torque motor torque -> [play, compliance, friction, cogging] -> joint -> tree
//   -> [encoder, delay, filter] -> predicted channels
//
// Integrator: linearly implicit midpoint with exact stopping by friction (a friction torque is what
// stops the joint within the step, clipped at what friction can give), so stiction, play and stiff
// gains need no tiny steps. Windows run in step, one a lane of the processor's vectors
// (window_run.h).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/diagnose/sim/actuator.h"
#include "tools/diagnose/sim/drive.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

/// Rows [first, last] of a recording, and where the joints are at row `first`, as the recording's
/// sensors show it.
struct Window {
  std::size_t first = 0, last = 0;
  std::vector<double> q,
      // n each, rad, rad/s: measured coordinates (encoder errors and sensor delay are undone
      // inside)
      dq;
};

/// Predicted channels at rows first..last of one window; entry of joint j and row k at [j * rows +
/// k - first].
struct Prediction {
  std::size_t first = 0, rows = 0;
  // n x rows; tau: motor torque at the output, before friction
  std::vector<double> q, dq, tau, i, pwm;
  std::vector<double> volt;  // rows, at the driver of joint 0
  std::span<const double> of(const std::vector<double>& channel, std::size_t joint) const {
    return {channel.data() + joint * rows, rows};
  }
};

/// Smoothed motion of a recording, used to bring inner states (integrators, bristles, play) to the
/// start of a window.
struct MeasuredMotion {
  std::vector<std::vector<double>> q, dq;  // by joint, by row
};

struct LaneUnit;

/// By joint.
using InnerStates = std::array<InnerState, kMaxJoints>;

struct SimOptions {
  double max_step_s = 1e-3;
  const MeasuredMotion* motion = nullptr;  // null: inner states start at rest at every window
  /// Inner states by window, from follow() with these options; null: `motion` is followed here.
  const std::vector<InnerStates>* starts = nullptr;
  std::uint64_t random_seed = 0;  // not 0: lost commands are drawn instead of averaged
  /// Only these joints are wanted (by joint, not 0: wanted; empty: all). Branches that hold none of
  /// them stay 0 in the prediction; what is simulated is bit for bit what it is without the choice.
  std::vector<char> wanted = {};
  /// How many windows run in step (lane_simulation.h); null: as many as this machine can. Changes
  /// no bit.
  const LaneUnit* unit = nullptr;
};

/// Simulates every window. Windows must be in order of `first`. Deterministic; no state is kept
/// between calls.
/// A motion that diverges is held at its last finite value. Precondition: drive made for the same
/// joints.
std::vector<Prediction> simulate(const SimParams& params, const Drive& drive,
                                 std::span<const Window> windows, const SimOptions& options = {});

/// Torque by row that the model's actuators and friction give when the joints move as measured: n x
/// rows (Prediction layout).
struct ReplayTorques {
  std::size_t rows = 0;
  std::vector<double> motor;     // N m, at the output, before friction
  std::vector<double> friction;  // N m, as it acts on the joint (opposes motion)
  std::vector<double> passive;   // N m, springs, cogging, stops, drag
  std::vector<double> current, duty;
};
/// A recording of a robot, and its joints as measured, by joint and row.
struct Replayed {
  const SimParams* params = nullptr;
  const Drive* drive = nullptr;
  const MeasuredMotion* motion = nullptr;
};
/// By recording. Those of robots that are equal but for their servos' gains and their links' masses
/// are replayed in step, which changes no bit. `options`: its step, its unit.
std::vector<ReplayTorques> replay_torques(std::span<const Replayed> recordings,
                                          const SimOptions& options = {});

/// Jitter: every reading of a position is taken a little early or late (JointParams::jitter),
/// in place.
void add_reading_jitter(const SimParams& params, std::uint64_t seed, Prediction& prediction);

}  // namespace sanso::diagnose
