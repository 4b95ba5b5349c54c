// Heights of one sole above the other: what a base that drifts cannot shift.
#include "host/app/foot_lift.h"

#include <algorithm>
#include <array>

#include "host/motion/make/body_kinematics.h"

namespace sanso::app {
namespace {

constexpr double kLift_m = 0.005;  // a reference that rises less lifts no foot

std::array<double, 2> heights_over_other_sole_m(const model::State& x) {
  const motion::BodyPoints points = motion::body_points(x);
  const double right = points.sole_height(0), left = points.sole_height(1);
  const double floor = std::min(right, left);
  return {right - floor, left - floor};
}

}  // namespace

double lifted_share(const learn::Episode& episode) {
  double done = 0.0, asked = 0.0;
  for (std::size_t i = 0; i < episode.ticks.size(); ++i) {
    const model::State x_ref =
        Eigen::Map<const Eigen::Matrix<float, model::kNx, 1>>(episode.reference[i].data())
            .cast<double>();
    const auto wanted = heights_over_other_sole_m(x_ref);
    if (std::max(wanted[0], wanted[1]) < kLift_m) continue;
    const auto seen = heights_over_other_sole_m(episode.ticks[i].x);
    for (std::size_t foot = 0; foot < 2; ++foot) {
      done += std::min(seen[foot], wanted[foot]) * wanted[foot];
      asked += wanted[foot] * wanted[foot];
    }
  }
  return asked > 0.0 ? done / asked : -1.0;
}

}  // namespace sanso::app
