// A recording of a standing robot as the balances of drive_rows.h need it: smoothed joints, what
// the base feels, how far every goal is away; and the means of all that over a window.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/wholebody/floating_tree.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

/// The first of a step's rows still shows what the command before it did.
struct JointTrack {
  std::vector<double> q, dq, ddq, error, command_rate, current;
};
struct Track {
  std::vector<JointTrack> joints;
  std::vector<V3> acc, w, dw;
  std::vector<V3> up;          // the vertical in base axes; empty: no attitude
  std::vector<double> weight;  // sum of all feet's forces, N; empty: none was recorded
  std::vector<FootForce> feet;
};

Track track_of(const Asking& asking, const WholeRecording& recording);

struct WindowMeans {
  FloatingMotion motion;
  Eigen::VectorXd sign, error, command_rate, current;
  V3 up = V3::Zero();
  double weight = 0.0;
  std::vector<int> in_air;  // joints of feet that carry nothing all the time
};

/// Means over rows [a, b).
WindowMeans window_of(const Asking& asking, const Track& track, std::size_t a, std::size_t b);

}  // namespace sanso::diagnose
