// A hidden world: the robot as it was really built, on MuJoCo, with whatever is hidden in it; and
// what its sensors log.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/conceal/experiment.h"
#include "tools/conceal/hidden_joint.h"
#include "tools/recording/recording.h"

namespace sanso::conceal {

inline constexpr double kCurrentQuantum = 2.69e-3;  // A, of a recorded current

/// A body that is on a link from an instant on, at the link's payload point.
struct LatePayload {
  int link = -1;
  double mass = 0, from_s = 0;
};

/// A constant force at a link's centre of mass, world axes, during [from, until).
struct LinkForce {
  int link = -1;
  Vec3 force{};
  double from_s = -1e9, until_s = 1e9;
};

/// Torque on one joint in proportion to another's rate: a belt or cable that the model does not
/// know of.
struct Coupling {
  int from = -1, to = -1;
  double viscous = 0;  // N m s/rad
};

struct WorldTruth {
  RobotSpec robot;
  std::vector<JointTruth> joints;
  double supply_level = 0, supply_slope_per_min = 0;  // relative
  double supply_resistance = 0;                       // ohm, carries the sum of |i duty|
  // the k-th joint's command comes k skews later
  double bus_skew_s = 0;
  LatePayload payload;
  LinkForce push, tether;
  Coupling coupling;
};

/// Signals at the rows of an experiment: [joint][row].
struct Signals {
  std::vector<std::vector<double>> q, dq, current, duty;
  std::vector<double> volt;  // at the driver
};

/// Runs an experiment. Deterministic: `seed` draws jitter and lost commands only.
Signals run_experiment(const WorldTruth& world, const Experiment& experiment, std::uint64_t seed);

/// What the bus logs of it: encoder steps, register units, noise.
recording::Recording as_recording(const WorldTruth& world, const Experiment& experiment,
                                  const Signals& signals, std::uint64_t seed,
                                  bool electrical_channels);

inline constexpr double kRateQuantum = 0.229 * 2 * plant::kPi / 60;  // rad/s

}  // namespace sanso::conceal
