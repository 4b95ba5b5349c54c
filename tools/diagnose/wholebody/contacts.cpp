// Lowest points by forward kinematics; a ground that nobody states is where the lowest rows are.
#include "tools/diagnose/wholebody/contacts.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

std::vector<TouchPoint> touch_points(const WholeBody& body) {
  std::vector<TouchPoint> out;
  for (const CollisionShape& shape : body.shapes) {
    for (const Vec3& p : shape.points)
      out.push_back({shape.link, shape.joint, eigen(p), shape.radius});
  }
  return out;
}

V3 upwards(const WholeBody& body) {
  const V3 g = eigen(body.model.gravity);
  return g.norm() > 0.0 ? V3(-g / g.norm()) : V3(V3::UnitZ());
}

Clearance clearance(const WholeRecording& r, const WholeBody& body, double pose_scale,
                    const WholeSettings& settings) {
  const std::vector<TouchPoint> points = touch_points(body);
  const V3 up = upwards(body);
  BodyKinematics kinematics(body);
  Clearance out;
  constexpr double kNone = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < r.rows(); ++k) {
    kinematics.set(r.R[k], r.p[k] / pose_scale, r.q.col(static_cast<Eigen::Index>(k)));
    double lowest = kNone, second = kNone;
    int which = -1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double h = up.dot(kinematics.at(points[i].joint, points[i].at)) - points[i].radius;
      if (h < lowest) {
        second = lowest, lowest = h, which = static_cast<int>(i);
      } else if (h < second) {
        second = h;
      }
    }
    out.lowest.push_back(lowest), out.second.push_back(second), out.point.push_back(which);
  }
  out.stated = body.ground.height.has_value();
  out.ground = out.stated ? *body.ground.height : quantile(out.lowest, settings.touching);
  for (double& h : out.lowest) h -= out.ground;
  for (double& h : out.second) h -= out.ground;
  return out;
}

std::vector<Span> spans(const WholeRecording& r, const std::vector<char>& holds) {
  std::vector<Span> out;
  for (std::size_t k = 0; k < r.rows();) {
    if (!holds[k]) {
      ++k;
      continue;
    }
    Span s{k, k + 1};
    while (s.last < r.rows() && holds[s.last] && r.piece[s.last] == r.piece[k]) ++s.last;
    out.push_back(s);
    k = s.last;
  }
  return out;
}

std::vector<Span> flights(const WholeRecording& r, const Clearance& c,
                          const WholeSettings& settings) {
  std::vector<char> up(r.rows(), 0);
  for (std::size_t k = 0; k < r.rows(); ++k) up[k] = c.lowest[k] > settings.clearance ? 1 : 0;
  std::vector<Span> out;
  const auto spread = static_cast<std::size_t>(std::ceil(settings.impact_spread / r.interval));
  for (Span s : spans(r, up)) {
    // the recording's own ends are no impacts
    if (s.first > 0) s.first += spread;
    if (s.last < r.rows()) s.last -= std::min(spread, s.last);
    if (s.last > s.first + 4 && r.t[s.last - 1] - r.t[s.first] >= settings.shortest_flight)
      out.push_back(s);
  }
  return out;
}

std::optional<V3> sole_normal(const WholeBody& body, int joint, const std::string& link) {
  std::vector<V3> points;
  for (const CollisionShape& s : body.shapes) {
    if (s.link == link && s.radius == 0.0)
      for (const Vec3& p : s.points) points.push_back(eigen(p));
  }
  if (points.size() < 4) return std::nullopt;
  BodyKinematics kinematics(body);
  kinematics.set(M3::Identity(), V3::Zero(),
                 Eigen::VectorXd::Zero(static_cast<Eigen::Index>(body.model.tree.size())));
  const M3& R = kinematics.rotation(joint);
  const V3 up = upwards(body);
  std::sort(points.begin(), points.end(),
            [&](const V3& a, const V3& b) { return up.dot(R * a) < up.dot(R * b); });
  V3 middle = V3::Zero();
  for (std::size_t i = 0; i < 4; ++i) middle += 0.25 * points[i];
  M3 spread = M3::Zero();
  for (std::size_t i = 0; i < 4; ++i)
    spread += (points[i] - middle) * (points[i] - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<M3> axes(spread);
  if (axes.eigenvalues()[1] < 1e-8) return std::nullopt;  // an edge, no face
  const V3 normal = axes.eigenvectors().col(0);
  return up.dot(R * normal) > 0.0 ? normal : V3(-normal);
}

}  // namespace sanso::diagnose
