#include <algorithm>
#include <cassert>
#include <cmath>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {
namespace {

/// Damping that the actuator itself gives: back-EMF of a servo, derivative gain of a position loop,
/// known friction.
double actuator_damping(const JointSettings& s) {
  double damping = s.viscous + s.kd;
  if (s.actuator == Actuator::dc_servo) damping += s.torque_constant * s.back_emf / s.resistance;
  return damping;
}

Nuisance make(const std::string& name, const std::string& id, double tolerance,
              std::vector<int> joints, std::vector<double> direction) {
  const Effect* effect = find_effect(id);
  assert(effect != nullptr && effect->parameters.size() == direction.size());
  Nuisance n;
  n.name = name;
  n.effect = id;
  n.tolerance = tolerance;
  n.joints = std::move(joints);
  n.null = effect->null();
  n.direction = std::move(direction);
  n.run = effect->apply;
  return n;
}

}  // namespace

std::vector<double> Nuisance::theta(double value) const {
  std::vector<double> out = null;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] += value * direction[i];
  return out;
}

void Nuisance::apply(SimParams& params, double value) const {
  // beyond these no body or gain remains; a fit that gets there has left every tolerance
  const double bounded = std::max(-0.9, value);
  const std::vector<double> values = theta(bounded);
  for (const int j : joints) run(params, j, values);
}

std::vector<Nuisance> make_nuisances(const Problem& problem) {
  std::vector<Nuisance> out;
  const SimParams& nominal = problem.sources.front().nominal;
  std::vector<int> all;
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    const std::string at = " of " + problem.joints[j];
    const std::vector<int> here{static_cast<int>(j)};
    all.push_back(static_cast<int>(j));
    const JointSettings& s = nominal.joints[j].nominal;
    const TreeJoint& joint = nominal.tree.joints[j];
    out.push_back(make("mass" + at, "link_mass", problem.settings.tolerances.mass, here, {1.0}));
    if (!joint.prismatic) {
      const Vec3& com = joint.body.com;
      out.push_back(make("length" + at, "link_com", problem.settings.tolerances.length, here,
                         {com[0], com[1], com[2]}));
    }
    if (const double damping = actuator_damping(s); damping > 0.0) {
      out.push_back(make("damping" + at, "viscous_friction", problem.settings.tolerances.damping,
                         here, {damping}));
    }
    if (s.coulomb > 0.0) {
      out.push_back(make("dry friction" + at, "coulomb_friction",
                         problem.settings.tolerances.friction, here, {s.coulomb}));
    }
    if (s.actuator == Actuator::dc_servo || s.actuator == Actuator::position_pd) {
      out.push_back(
          make("gain" + at, "servo_p_gain", problem.settings.tolerances.gain, here, {1.0}));
    }
    if (s.actuator == Actuator::dc_servo) {
      out.push_back(make("torque constant" + at, "torque_constant",
                         problem.settings.tolerances.motor, here, {1.0, 0.0}));
      out.push_back(make("resistance" + at, "torque_constant", problem.settings.tolerances.motor,
                         here, {0.0, 1.0}));
    }
    const double zero =
        joint.prismatic ? 0.1 * problem.settings.tolerances.zero : problem.settings.tolerances.zero;
    out.push_back(make("zero" + at, "encoder_offset", zero, here, {1.0}));
    if (s.armature > 0.0)
      out.push_back(make("rotor inertia" + at, "rotor_inertia",
                         problem.settings.tolerances.armature, here, {s.armature}));
  }
  // Either way: a servo that samples at 1 kHz tracks as if its commands came half a sample early.
  // Bounded at zero, the fraction of a millisecond takes the next name that can shift a command
  // forward (feed-forward).
  out.push_back(make("common lag", "command_delay", problem.settings.tolerances.lag, all, {1.0}));
  return out;
}

bool at_null(const CandidateParameter& p, double value) {
  return std::abs(value - p.null) <= 1e-6 * std::max(p.typical, p.high - p.low);
}

bool Model::has(int candidate) const {
  return std::any_of(effects.begin(), effects.end(),
                     [&](const Chosen& c) { return c.candidate == candidate; });
}

void Library::apply(const Model& model, SimParams& params) const {
  for (std::size_t i = 0; i < model.nuisance.size(); ++i) {
    if (model.nuisance[i] != 0.0) nuisances[i].apply(params, model.nuisance[i]);
  }
  for (const Chosen& c : model.effects)
    candidates[static_cast<std::size_t>(c.candidate)].apply(params, c.theta);
}

std::string Candidate::title() const {
  std::string text = effect;
  for (std::size_t i = 0; i < where.size(); ++i) text += (i == 0 ? " at " : ", ") + where[i];
  return text;
}

}  // namespace sanso::diagnose
