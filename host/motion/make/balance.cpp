// com_for_zmp solves a tridiagonal system (the pendulum in central differences); zmp_of takes
// second differences of all bodies.
#include "host/motion/make/balance.h"

#include <algorithm>

#include "host/motion/make/body_kinematics.h"
#include "shared/model/step_model.h"

namespace sanso::motion {

std::vector<double> com_for_zmp(const std::vector<double>& zmp, double com_height_m, double dt_s) {
  // tridiagonal (Thomas); the end rows hold c on p: standing
  const std::size_t n = zmp.size();
  std::vector<double> c = zmp;
  if (n < 3) return c;
  const double a = com_height_m / (model::kGravity_m_s2 * dt_s * dt_s);
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = 1.0 + 2.0 * a + a * upper[i - 1];
    upper[i] = -a / pivot;
    c[i] = (zmp[i] + a * c[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) c[i] -= upper[i] * c[i + 1];
  return c;
}

std::vector<ZmpSample> zmp_of(const Trajectory& trajectory) {
  const std::size_t n = trajectory.x.size();
  std::vector<BodyPoints> points;
  points.reserve(n);
  for (const auto& x : trajectory.x) points.push_back(body_points(x));

  std::vector<ZmpSample> zmp(n);
  const double dt2 = trajectory.dt_s * trajectory.dt_s;
  for (std::size_t k = 0; k < n; ++k) {
    // second differences need both neighbours; the ends use those of their neighbour sample
    const std::size_t i = std::clamp<std::size_t>(k, 1, n - 2);
    double moment_x = 0.0, moment_y = 0.0, force = 0.0, weight = 0.0;
    for (int b = 0; b < model::kNumBodies; ++b) {
      const double mass = model::kOp3Bodies[b].mass;
      const math::Vec3 p = points[k].p_world_com[b];
      const math::Vec3 acceleration = (points[i + 1].p_world_com[b] - 2 * points[i].p_world_com[b] +
                                       points[i - 1].p_world_com[b]) /
                                      dt2;
      const double vertical = mass * (acceleration.z() + model::kGravity_m_s2);
      moment_x += vertical * p.x() - mass * acceleration.x() * p.z();
      moment_y += vertical * p.y() - mass * acceleration.y() * p.z();
      force += vertical;
      weight += mass * model::kGravity_m_s2;
    }
    zmp[k].load = force / weight;
    if (zmp[k].load > 0.1) {
      zmp[k].x = moment_x / force;
      zmp[k].y = moment_y / force;
    } else if (k > 0) {
      zmp[k].x = zmp[k - 1].x;
      zmp[k].y = zmp[k - 1].y;
    }
  }
  return zmp;
}

}  // namespace sanso::motion
