// `sanso bench falls`: a standing robot is pushed over in every direction, with the limbs drawn in
// before the impact and without, and what hits the ground is measured.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sanso::campaign {

struct FallOptions {
  int directions = 12;   // of the push, evenly around the vertical
  double push_N = 20.0;  // at the torso, for 0.15 s
  std::uint64_t seed = 1;
  std::string world = "lab";
  bool json = false;
};

/// What one fall came to. All of the torso, from the push until a second after the first impact.
struct Fall {
  double heading_rad = 0.0;        // of the push, from straight ahead to the left
  bool fell = false;               // something other than the feet touched the ground
  double after_s = 0.0;            // from the push to that
  double speed_m_s = 0.0;          // then
  double rate_rad_s = 0.0;         // then
  double deceleration_m_s2 = 0.0;  // largest mean one over a tick
  double joint_jerk_rad_s = 0.0;   // largest change of a servo's rate in a tick: gears feel it
  double released_s = -1.0;        // from the push until all torque is off; -1: never
};

/// A push in `world`; `tuck_s` as in `guard.tuck_s`. Throws plant::WorldError for an unknown world.
Fall fall(const FallOptions& options, double heading_rad, double tuck_s);

/// Prints every fall and the medians of both kinds. Exit code 0; 1 when a robot that fell kept its
/// torque.
int bench_falls(const FallOptions& options);

}  // namespace sanso::campaign
