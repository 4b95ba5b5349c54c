// Sums over links, each with the velocity that the joints before it give it.
#include "tests/oracle/op3_momentum.h"

#include <Eigen/Geometry>

namespace sanso::model {
namespace {

Vec3 vec(const double* v) { return {v[0], v[1], v[2]}; }

// Angular velocity of a link and velocity of its centre of mass, world axes.
struct LinkVelocity {
  Vec3 w, v_com;
};

template <class Visit>
void for_each_link_velocity(const StepModel& model, const Kinematics& kin, const State& x,
                            Visit visit) {
  Vec3 w[kNumBodies], v[kNumBodies];
  w[0] = kin.R_world_link[0] * x.segment<3>(kXOmega);
  v[0] = x.segment<3>(kXVel);
  for (int i = 0; i < kNumBodies; ++i) {
    if (i > 0) {
      const int p = parent_body(i);
      w[i] = w[p] + kin.axis_world[i - 1] * x[kXJointRate + i - 1];
      v[i] = v[p] + w[p].cross(kin.p_world_link[i] - kin.p_world_link[p]);
    }
    const Vec3 r = kin.R_world_link[i] * vec(model.body[i].first_moment) / model.body[i].mass;
    visit(i, LinkVelocity{w[i], v[i] + w[i].cross(r)}, kin.p_world_link[i] + r);
  }
}

// Inertia about the centre of mass, world axes.
Mat3 central_inertia(const StepModel::Body& b, const Mat3& R) {
  const double* I = b.inertia;
  Mat3 about_origin;
  about_origin << I[0], I[1], I[2], I[1], I[3], I[4], I[2], I[4], I[5];
  const Mat3 S = math::skew(vec(b.first_moment));
  // skew(c)^2 m = -(parallel-axis term)
  return R * (about_origin + S * S / b.mass) * R.transpose();
}

}  // namespace

Momentum momentum(const StepModel& model, const Kinematics& kin, const State& x) {
  Momentum total{Vec3::Zero(), Vec3::Zero()};
  const Vec3 com = centre_of_mass(model, kin);
  for_each_link_velocity(model, kin, x, [&](int i, const LinkVelocity& link, const Vec3& p_com) {
    const Vec3 linear = model.body[i].mass * link.v_com;
    total.linear += linear;
    total.angular +=
        central_inertia(model.body[i], kin.R_world_link[i]) * link.w + (p_com - com).cross(linear);
  });
  return total;
}

double energy(const StepModel& model, const Kinematics& kin, const State& x) {
  double sum = 0.0;
  for_each_link_velocity(model, kin, x, [&](int i, const LinkVelocity& link, const Vec3& p_com) {
    const double m = model.body[i].mass;
    sum += 0.5 * m * link.v_com.squaredNorm() - m * vec(model.gravity_world).dot(p_com) +
           0.5 * link.w.dot(central_inertia(model.body[i], kin.R_world_link[i]) * link.w);
  });
  return sum;
}

}  // namespace sanso::model
