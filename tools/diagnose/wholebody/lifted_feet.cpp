// Heights are held against each other, so nobody has to know where the base is. A floor that leans
// and an attitude that is off move them by less than the clearance that is asked for.
#include "tools/diagnose/wholebody/lifted_feet.h"

#include <algorithm>
#include <limits>
#include <map>

#include "tools/diagnose/wholebody/contacts.h"

namespace sanso::diagnose {

std::vector<std::vector<int>> lifted_feet(const Asking& asking, const WholeRecording& r) {
  const std::vector<TouchPoint> points = touch_points(asking.body);
  if (!r.attitude || !r.feet.empty() || points.empty()) return {};
  const V3 up = upwards(asking.body);
  BodyKinematics kinematics(asking.body);
  std::vector<std::vector<int>> out(r.rows());
  for (std::size_t k = 0; k < r.rows(); ++k) {
    kinematics.set(r.R[k], V3::Zero(), r.q.col(static_cast<Eigen::Index>(k)));
    std::map<int, double> heights;  // of the lowest point, by joint
    double ground = std::numeric_limits<double>::infinity();
    for (const TouchPoint& p : points) {
      const double h = up.dot(kinematics.at(p.joint, p.at)) - p.radius;
      const auto [at, first] = heights.try_emplace(p.joint, h);
      if (!first) at->second = std::min(at->second, h);
      ground = std::min(ground, h);
    }
    for (const auto& [joint, height] : heights)
      if (height > ground + asking.stance.lifted) out[k].push_back(joint);
  }
  return out;
}

}  // namespace sanso::diagnose
