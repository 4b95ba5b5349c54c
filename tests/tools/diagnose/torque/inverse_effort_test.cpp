// The equations of motion read backwards give what the simulator was driven with, and hold apart
// what accelerates, what pulls and what rubs.
#include "tools/diagnose/torque/inverse_effort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/made_effort.h"
#include "tests/support/noisy_world.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr const char* kTorque =
    "actuator = \"torque\"\ntorque_limit = 0.0\nviscous = 0.05\n"
    "coulomb = 0.04\narmature = 0.02\n";

/// Largest difference between the torque that drove the simulator and the one read backwards from
/// its steps, over all joints that did not turn about, N m (N).
double largest_error(const ModelFolder& world, int* compared = nullptr) {
  const SimParams params = params_with_effects(world);
  constexpr double kStep = 5e-4;
  const Drive drive = make_test_drive(world, 4.0, kStep, [](int j, double t) {
    return 1.2 * std::sin((2.1 + 1.3 * j) * t) + 0.7 * std::sin((5.3 + 0.9 * j) * t + j);
  });
  SimOptions options;
  options.max_step_s = kStep;
  const Prediction p =
      simulate(params, drive, std::vector<Window>{whole_from_rest(drive)}, options).front();
  InverseEffort inverse(params);
  double worst = 0.0;
  for (std::size_t k = 0; k + 1 < drive.rows(); ++k) {
    MotionSample m;
    for (std::size_t i = 0; i < params.size(); ++i) {
      const auto q = p.of(p.q, i), dq = p.of(p.dq, i);
      m.q[i] = 0.5 * (q[k] + q[k + 1]);
      m.dq[i] = 0.5 * (dq[k] + dq[k + 1]);
      m.ddq[i] = (dq[k + 1] - dq[k]) / kStep;
    }
    const std::vector<NeededEffort> needed = inverse.at(m);
    for (std::size_t j = 0; j < needed.size(); ++j) {
      if (std::abs(m.dq[j]) < 0.1) continue;  // friction at rest may have any value
      worst = std::max(worst, std::abs(needed[j].total() - drive.joints[j].command[k]));
      if (compared != nullptr) ++*compared;
    }
  }
  return worst;
}

TEST(InverseEffort, IsWhatTheSimulatorWasDrivenWith) {
  for (const ModelFolder& model : {pendulum(kTorque), two_links(kTorque), arm(kTorque)}) {
    int compared = 0;
    EXPECT_LT(largest_error(model, &compared), 0.01);
    EXPECT_GT(compared, 2000);
  }
}

TEST(InverseEffort, KnowsEveryLawOfTheSimulatorThatHasNoMemory) {
  const std::vector<EffectEntry> effects{
      hidden("coulomb_friction", "a", {{"coulomb", 0.2}}),
      hidden("viscous_friction", "a", {{"viscous", 0.1}}),
      hidden("stribeck_friction", "a", {{"stribeck", 0.2}, {"speed", 0.5}, {"shape", 1.0}}),
      hidden("asymmetric_friction", "a",
             {{"coulomb_difference", 0.03}, {"viscous_difference", 0.02}}),
      hidden("air_drag", "a", {{"drag", 0.05}}),
      hidden("cable_spring", "a", {{"stiffness", 0.5}, {"torque", 0.2}}),
      hidden("rotor_inertia", "a", {{"armature", 0.05}}),
      hidden("cogging", "a", {{"sine", 0.1}, {"cosine", -0.05}, {"order", 3.0}}),
      hidden("position_friction", "a", {{"sine", 0.02}, {"cosine", 0.01}, {"order", 2.0}})};
  for (const EffectEntry& effect : effects) {
    SCOPED_TRACE(effect.id);
    const ModelFolder model = two_links(kTorque);
    const ModelFolder world = hiding(model, {effect});
    EXPECT_LT(largest_error(world), 0.01);
  }
  EXPECT_LT(largest_error(hiding(two_links(kTorque), effects)), 0.02);
}

TEST(InverseEffort, HoldsApartAccelerationAndWhatActsWithoutIt) {
  const SimParams params = make_params(arm(kTorque));
  InverseEffort inverse(params);
  TreeDynamics tree(params.tree, params.gravity);
  for (int k = 0; k < 20; ++k) {
    const MotionSample m = made_motion(3, 0.7 * k);
    const std::vector<NeededEffort> needed = inverse.at(m);
    tree.set_positions(m.q.data());
    JointMatrix M{};
    JointVector h{};
    tree.mass_matrix(M);
    tree.bias(m.dq.data(), h);
    for (std::size_t i = 0; i < 3; ++i) {
      double load = h[i];
      for (std::size_t j = 0; j < 3; ++j)
        load += M[std::max(i, j) * kMaxJoints + std::min(i, j)] * m.ddq[j];
      EXPECT_NEAR(needed[i].load, load, 1e-10);
      EXPECT_NEAR(needed[i].external, -h[i], 1e-10);
      const double friction = m.dq[i] > 0.0 ? 0.04 : -0.04;
      EXPECT_NEAR(needed[i].joint, 0.02 * m.ddq[i] + 0.05 * m.dq[i] + friction, 1e-12);
    }
  }
}

TEST(InverseEffort, HoldsAPendulumAgainstItsWeight) {
  InverseEffort inverse(make_params(pendulum("actuator = \"torque\"\n")));
  for (const double q : {-2.0, -0.5, 0.0, 0.8, 1.57}) {
    MotionSample m;
    m.q[0] = q;
    const NeededEffort held = inverse.at(m).front();
    EXPECT_NEAR(held.total(), 0.5 * 9.81 * 0.1 * std::sin(q), 1e-9);
    EXPECT_NEAR(held.external, -held.load, 1e-12);
    m.ddq[0] = 2.0;
    EXPECT_NEAR(inverse.at(m).front().load - held.load, 2.0 * (0.5 * 0.01 + 1e-6), 1e-9);
  }
}

TEST(InverseEffort, ALatePayloadIsThereFromTheStart) {
  SimParams late = make_params(two_links(kTorque)), there = late;
  BodyInertia body;
  body.mass = 0.3;
  body.com = {0.02, 0.0, -0.25};
  late.late_payloads.push_back({1, body, 5.0});
  add_body(there.tree.joints[1].body, body);
  InverseEffort a(late), b(there), none(make_params(two_links(kTorque)));
  const MotionSample m = made_motion(2, 1.3);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_NEAR(a.at(m)[j].load, b.at(m)[j].load, 1e-12);
    EXPECT_GT(std::abs(a.at(m)[j].load - none.at(m)[j].load), 0.01);
  }
}

TEST(InverseEffort, AForceIsTakenByItsLeverUnlessItBegins) {
  const SimParams plain = make_params(two_links(kTorque));
  SimParams pushed = plain, begins = plain, ends = plain;
  const Vec3 force{1.5, 0.0, 0.7};
  pushed.forces.push_back({1, force});
  begins.forces.push_back({1, force, 2.0});
  ends.forces.push_back({1, force, -kNone, 2.0});
  InverseEffort a(plain), b(pushed), c(begins), d(ends);
  TreeDynamics tree(plain.tree, plain.gravity);
  const MotionSample m = made_motion(2, 0.4);
  constexpr double kStep = 1e-6;
  for (std::size_t j = 0; j < 2; ++j) {
    JointVector above = m.q, below = m.q;
    above[j] += kStep, below[j] -= kStep;
    tree.set_positions(above.data());
    const Vec3 high = tree.com(1);
    tree.set_positions(below.data());
    const Vec3 low = tree.com(1);
    double torque = 0.0;  // of the force, by virtual work: the motor has that much less to give
    for (std::size_t i = 0; i < 3; ++i) torque += force[i] * (high[i] - low[i]) / (2.0 * kStep);
    EXPECT_NEAR(b.at(m)[j].load, a.at(m)[j].load - torque, 1e-7);
    EXPECT_NEAR(b.at(m)[j].external, a.at(m)[j].external + torque, 1e-7);
    EXPECT_EQ(c.at(m)[j].load, a.at(m)[j].load);
    EXPECT_EQ(d.at(m)[j].load, a.at(m)[j].load);
  }
}

TEST(InverseEffort, FrictionTurnsWithTheSpeedAndIsNoneAtRest) {
  JointParams joint;
  joint.nominal.coulomb = 0.1;
  joint.load_friction = 0.2, joint.drive_friction = 0.3, joint.backdrive_friction = 0.1;
  const double load = 2.0, external = -1.0;
  // 0.1 + 0.2 |2 + 1| + |0.3 * 2 + 0.1 * 1|
  EXPECT_NEAR(joint_effort(joint, 0, 1.0, 0, load, external), 1.4, 1e-12);
  EXPECT_NEAR(joint_effort(joint, 0, -1.0, 0, load, external), -1.4, 1e-12);
  EXPECT_EQ(joint_effort(joint, 0, 0.0, 0, load, external), 0.0);
}

}  // namespace
}  // namespace sanso::diagnose
