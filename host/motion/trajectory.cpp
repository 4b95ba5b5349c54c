// Velocities by central differences of the poses, the orientation's in the tangent.
#include "host/motion/trajectory.h"

#include <algorithm>

namespace sanso::motion {

void differentiate_poses(Trajectory& trajectory) {
  auto& x = trajectory.x;
  const int last = static_cast<int>(x.size()) - 1;
  if (last < 1) return;
  std::vector<model::State> poses = x;
  for (int k = 0; k <= last; ++k) {
    const int before = std::max(k - 1, 0), after = std::min(k + 1, last);
    const double span_s = (after - before) * trajectory.dt_s;
    const model::Tangent d = model::minus(poses[after], poses[before]);
    // base angular velocity: rotation from `before` to `after`, in base axes (the same in both for
    // a constant rate)
    x[k].segment<3>(model::kXVel) = d.segment<3>(model::kDPos) / span_s;
    x[k].segment<3>(model::kXOmega) = d.segment<3>(model::kDTheta) / span_s;
    x[k].segment<model::kNumJoints>(model::kXJointRate) =
        d.segment<model::kNumJoints>(model::kDJoint) / span_s;
  }
}

}  // namespace sanso::motion
