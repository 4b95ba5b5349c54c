// A recording of a standing robot as the balances of drive_rows.h need it: smoothed joints, what
// the base feels, how far every goal is away; and the means of all that over a window.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/wholebody/floating_tree.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

/// A joint by row. The first of a step's rows still shows what the command before it did.
struct JointTrack {
  // rad (less the encoder's zero), rad/s, rad/s^2; goal that acts less position as recorded, rad;
  // the goal's rate, rad/s; A (empty: not recorded)
  std::vector<double> q, dq, ddq, error, command_rate, current;
};
/// A recording by row.
struct Track {
  std::vector<JointTrack> joints;
  // FloatingMotion's: specific force at the base's origin, m/s^2; rad/s; rad/s^2; base axes
  std::vector<V3> acc, w, dw;
  std::vector<V3> up;          // the vertical in base axes; empty: no attitude
  std::vector<double> weight;  // sum of all feet's forces, N; empty: none was recorded
  std::vector<FootForce> feet;
  std::vector<std::vector<int>> lifted;  // joints of feet in the air (lifted_feet.h)
  std::vector<char> impact;              // a foot comes down or off
};

/// The recording must have every joint's goal and position, and the accelerometer. A weight is NaN
/// where a foot comes down or off. `lags`: by joint, s, from a goal to its loop; empty: none.
Track track_of(const Asking& asking, const WholeRecording& recording,
               const Eigen::VectorXd& lags = {});

/// Means of a window, units of the tracks; vectors by joint.
struct WindowMeans {
  FloatingMotion motion;
  // sign: of the velocity, within [-1, 1], the direction of dry friction; others as in the track
  Eigen::VectorXd sign, error, command_rate, current;
  V3 up = V3::Zero();               // zero: no attitude
  double weight = 0.0;              // N
  std::vector<int> in_air;          // joints of feet that carry nothing all the time
  std::vector<std::size_t> stands;  // feet of the track that carry a good part all the time
};

/// A foot comes down or off in rows [a, b) or within their number beside them: smoothing spreads
/// what an impact does, and neither accelerations nor torques are what a mean says of them.
bool impact_near(const Track& track, std::size_t a, std::size_t b);

/// Means over rows [a, b) of the track.
WindowMeans window_of(const Asking& asking, const Track& track, std::size_t a, std::size_t b);

/// A window of a recording in which no foot comes down or off.
struct StandingWindow {
  std::size_t recording = 0;
  double from = 0.0, to = 0.0;  // s
  WindowMeans means;
  std::vector<FootForce> feet;  // that stand
};

/// All that can be asked: finite, inside one piece of a recording, after the goals that were sent
/// before it began. `lags`: of track_of().
std::vector<StandingWindow> windows_of(const Asking& asking, const Eigen::VectorXd& lags);

}  // namespace sanso::diagnose
