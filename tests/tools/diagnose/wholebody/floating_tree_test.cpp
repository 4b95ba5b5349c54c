// The forces that a motion needs are those by which its momentum and its energy change; columns of
// masses and moments add up to what the links need.
#include "tools/diagnose/wholebody/floating_tree.h"

#include <gtest/gtest.h>

#include "shared/math/so3.h"
#include "shared/model/step_model.h"
#include "tools/diagnose/run/planner_model.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

struct Moving {
  WholeBody body = planner_body(model::nominal_parameters());
  Eigen::VectorXd q, dq, ddq;
  V3 v, a, w, dw;  // world axes, of a base that is upright in the world at t = 0
  explicit Moving(unsigned long seed) {
    Random random(seed);
    const int n = body.model.tree.size();
    const auto drawn = [&](double s) { return s * random.normal(); };
    for (Eigen::VectorXd* x : {&q, &dq, &ddq}) {
      x->resize(n);
      for (double& e : *x) e = drawn(x == &q ? 0.4 : 1.0);
    }
    for (V3* x : {&v, &a, &w, &dw}) *x = V3(drawn(0.5), drawn(0.5), drawn(0.5));
  }
  /// Kinematics a time t later.
  BodyKinematics at(double t) const {
    BodyKinematics out(body);
    const V3 turn = w * t + 0.5 * dw * t * t;
    out.set(math::rotation_matrix(math::quat_exp(turn)), v * t + 0.5 * a * t * t,
            q + dq * t + 0.5 * ddq * t * t);
    return out;
  }
};

Eigen::VectorXd needed(const Moving& m) {
  FloatingTree tree(m.body);
  tree.set({m.a + V3(0, 0, 9.81), m.w, m.dw, m.q, m.dq, m.ddq});
  return tree.needed();
}

TEST(FloatingTree, NeedsWhatMomentumGains) {
  for (unsigned long seed = 1; seed < 6; ++seed) {
    const Moving m(seed);
    constexpr double h = 1e-4;
    const V3 com[] = {m.at(-h).com(), m.at(0).com(), m.at(h).com()};
    const V3 acc = (com[2] - 2 * com[1] + com[0]) / (h * h);
    const Eigen::VectorXd f = needed(m);
    EXPECT_LT((f.head<3>() - m.body.mass() * (acc + V3(0, 0, 9.81))).norm(), 1e-4) << seed;
    // moment about the base's origin: of gravity, of the acceleration, of the spin
    const V3 spin = (m.at(0).spin_to(m.at(h)) - m.at(-h).spin_to(m.at(0))) / (h * h);
    const V3 moment = com[1].cross(m.body.mass() * (acc + V3(0, 0, 9.81))) + spin;
    EXPECT_LT((f.segment<3>(3) - moment).norm(), 2e-3) << seed;
  }
}

TEST(FloatingTree, AJointNeedsWhatGravityTakesFromIt) {
  Moving m(7);
  for (V3* x : {&m.a, &m.w, &m.dw, &m.v}) x->setZero();
  m.dq.setZero(), m.ddq.setZero();
  const Eigen::VectorXd f = needed(m);
  constexpr double h = 1e-6;
  for (Eigen::Index j = 0; j < m.q.size(); ++j) {
    Moving up = m, down = m;
    up.q[j] += h, down.q[j] -= h;
    const double rises = (up.at(0).com().z() - down.at(0).com().z()) / (2 * h);
    EXPECT_NEAR(f[6 + j], 9.81 * m.body.mass() * rises, 1e-6) << j;
  }
}

TEST(FloatingTree, ColumnsAddUp) {
  Moving m(9);
  const Eigen::VectorXd before = needed(m);
  FloatingTree tree(m.body);
  tree.set({m.a + V3(0, 0, 9.81), m.w, m.dw, m.q, m.dq, m.ddq});
  BodyInertia& b = m.body.model.tree.joints[3].body;
  const V3 at(0.02, -0.01, 0.03);
  add_body(b, {0.4, {at[0], at[1], at[2]}, {}});
  Eigen::VectorXd carried = 0.4 * tree.of_mass(3);
  for (int i = 0; i < 3; ++i) carried += 0.4 * at[i] * tree.of_moment(3, i);
  // what its size adds is of second order in its distance
  EXPECT_LT((needed(m) - before - carried).norm(), 0.02 * carried.norm());
}

}  // namespace
}  // namespace sanso::diagnose
