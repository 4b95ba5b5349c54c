// Nominal figures of the OP3 with their sources, and the constant form that the step reads:
// inertias about link origins, limits, friction.
#include "shared/model/step_model.h"

namespace sanso::model {
namespace {

constexpr ServoParameters kXm430{
    .stiffness =
        13.2,  // 4.1 N m x 560 / 128 x 651.9 / 885 duty per rad   [XM430 data sheet, P gain 560]
    .damping = 1.0,    // 0.85 back-EMF (4.1 N m at stall, 4.82 rad/s without load) + 0.15 viscous
    .armature = 0.03,  // middle of the plausible interval 0.012 .. 0.045
    .coulomb =
        0.0,  // dry friction switches sign inside a step: left to the residual model by default
    .torque_limit = 4.1};  // stall at 12 V

// Inertia about the link origin from inertia about the centre of mass (parallel-axis theorem).
StepModel::Body about_origin(const BodyInertia& b) {
  const double m = b.mass, x = b.com[0], y = b.com[1], z = b.com[2];
  return {.mass = m,
          .first_moment = {m * x, m * y, m * z},
          .inertia = {b.inertia[0] + m * (y * y + z * z), b.inertia[1] - m * x * y,
                      b.inertia[2] - m * x * z, b.inertia[3] + m * (x * x + z * z),
                      b.inertia[4] - m * y * z, b.inertia[5] + m * (x * x + y * y)},
          .subtree_mass = m};
}

}  // namespace

ModelParameters nominal_parameters() {
  ModelParameters theta{};
  for (int i = 0; i < kNumBodies; ++i) theta.body[i] = kOp3Bodies[i];
  for (auto& servo : theta.servo) servo = kXm430;
  theta.friction_forward = theta.friction_sideways = 0.8;  // rubber sole on wood
  return theta;
}

ModelParameters skating_parameters() {
  ModelParameters theta = nominal_parameters();
  theta.foot = kSkates;
  theta.friction_forward = 0.02;
  theta.friction_sideways = 0.6;
  for (int foot = 6; foot <= 12; foot += 6) {
    BodyInertia& b = theta.body[foot];
    const double whole = b.mass + kSkateMass;
    const double place[3] = {kSoleCentreX, foot == 12 ? kSoleCentreY : -kSoleCentreY,
                             kSoleHeight - 0.75 * kWheelRadius};
    double off[3];
    for (int i = 0; i < 3; ++i) off[i] = place[i] - b.com[i];
    const double m = b.mass * kSkateMass / whole;  // of two masses about their centre
    const double xx = off[0] * off[0], yy = off[1] * off[1], zz = off[2] * off[2];
    const double more[6] = {yy + zz, -off[0] * off[1], -off[0] * off[2],
                            xx + zz, -off[1] * off[2], xx + yy};
    for (int i = 0; i < 6; ++i) b.inertia[i] += m * more[i];
    // the skate's own, its mass at wheels and frame: about half its base and track
    const double x2 = kSkates.half_length * kSkates.half_length,
                 y2 = kSkates.half_width * kSkates.half_width;
    b.inertia[0] += kSkateMass * y2;
    b.inertia[3] += kSkateMass * x2;
    b.inertia[5] += kSkateMass * (x2 + y2);
    for (int i = 0; i < 3; ++i) b.com[i] += off[i] * kSkateMass / whole;
    b.mass = whole;
  }
  return theta;
}

StepModel make_step_model(const ModelParameters& theta) {
  StepModel model{};
  for (int i = 0; i < kNumBodies; ++i) model.body[i] = about_origin(theta.body[i]);
  // each leg is a chain: add from the foot upwards, then both legs to the base
  for (int leg = 0; leg < kNumFeet; ++leg) {
    const int hip = 1 + 6 * leg;
    for (int i = hip + 4; i >= hip; --i)
      model.body[i].subtree_mass += model.body[i + 1].subtree_mass;
    model.body[0].subtree_mass += model.body[hip].subtree_mass;
  }
  for (int j = 0; j < kNumJoints; ++j) model.servo[j] = theta.servo[j];
  model.friction_forward = theta.friction_forward;
  model.friction_sideways = theta.friction_sideways;
  model.ground_height = theta.ground_height;
  model.target_lag_s = theta.target_lag_s;
  model.gravity_world[2] = -kGravity_m_s2;
  model.contact = ContactSettings{};
  model.foot = theta.foot;
  return model;
}

}  // namespace sanso::model
