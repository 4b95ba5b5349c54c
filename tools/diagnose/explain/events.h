// Errors that stand alone: a few short stretches, far above all others. A push, a breakaway, a lost
// command. Fits weigh such shots down, and half of them may lie where the search does not look; so
// they are looked for by themselves, over all of the recorded time.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose {

/// A shot in which one joint's position error is far above noise and above the same joint's other
/// shots.
struct Event {
  std::size_t shot = 0;
  std::size_t joint = 0;
  double level = 0.0;   // RMS of the position error, noise levels (or trust floors)
  double excess = 0.0;  // energy beyond that of the joint's median shot, in units of noise energy
};

/// Position errors `projected` (StartElimination::project) of more than shot_outlier times the
/// level of the joint's median shot, or of noise where that is larger, or of `usual` (mean square
/// by channel and shot, channels of positions; empty: none); strongest first.
std::vector<Event> find_events(const Problem& problem, const Eigen::VectorXd& projected,
                               const Eigen::MatrixXd& usual = {});

/// Mean square of every channel's position error in every shot, in units of the channel's floor.
Eigen::MatrixXd mean_squares(const Problem& problem, const Eigen::VectorXd& projected);

/// Energy of all events at the joint where it is largest, without that joint's strongest event:
/// what happens once is an accident and says nothing about the robot. Compare with
/// practical_energy.
struct RepeatedEvents {
  std::optional<std::size_t> joint;  // none: there are no two events at any joint
  double energy = 0.0;
};
/// `events`: strongest first.
RepeatedEvents repeated(const std::vector<Event>& events);

/// Where a recording's events begin, s on its own clock: of the strongest shots, none twice, at
/// most `limit`.
std::vector<double> instants_of(const Comparison& comparison, const std::vector<Event>& events,
                                std::size_t limit);

}  // namespace sanso::diagnose
