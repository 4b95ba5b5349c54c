#include <algorithm>
#include <cmath>

#include "tools/diagnose/constants.h"
#include "tools/diagnose/search/candidate.h"

namespace sanso::diagnose {
namespace {

void scale_body(BodyInertia& body, double mass, double length) {
  body.mass *= mass;
  for (double& c : body.com) c *= length;
  for (double& i : body.about_com) i *= mass * length * length;
}

/// Damping that the actuator itself gives: back-EMF of a servo, derivative gain of a position loop, known friction.
double actuator_damping(const JointSettings& s) {
  double damping = s.viscous + s.kd;
  if (s.actuator == Actuator::dc_servo) damping += s.torque_constant * s.back_emf / s.resistance;
  return damping;
}

}  // namespace

std::vector<Nuisance> make_nuisances(const Problem& problem) {
  std::vector<Nuisance> out;
  const SimParams& nominal = problem.sources.front().nominal;
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    const std::string at = " of " + problem.joints[j];
    const JointSettings& s = nominal.joints[j].nominal;
    const bool feedback = s.actuator == Actuator::dc_servo || s.actuator == Actuator::position_pd;
    out.push_back({"mass" + at, constants::kMassTolerance, false,
                   [j](SimParams& p, double d) { scale_body(p.tree.joints[j].body, std::max(0.05, 1 + d), 1.0); }});
    if (!nominal.tree.joints[j].prismatic) {
      out.push_back({"length" + at, constants::kLengthTolerance, false,
                     [j](SimParams& p, double d) { scale_body(p.tree.joints[j].body, 1.0, std::max(0.05, 1 + d)); }});
    }
    if (const double damping = actuator_damping(s); damping > 0.0) {
      out.push_back({"damping" + at, constants::kDampingTolerance, false,
                     [j, damping](SimParams& p, double d) { p.joints[j].viscous += d * damping; }});
    }
    if (feedback) {
      out.push_back({"gain" + at, constants::kGainTolerance, false,
                     [j](SimParams& p, double d) { p.joints[j].p_scale *= std::max(0.05, 1 + d); }});
    }
    const double zero = nominal.tree.joints[j].prismatic ? 0.1 * constants::kZeroTolerance : constants::kZeroTolerance;
    out.push_back({"zero" + at, zero, false, [j](SimParams& p, double d) { p.joints[j].encoder_offset += d; }});
    if (s.armature > 0.0) {
      out.push_back({"rotor inertia" + at, constants::kArmatureTolerance, false,
                     [j, a = s.armature](SimParams& p, double d) { p.joints[j].armature += std::max(-0.95, d) * a; }});
    }
  }
  out.push_back({"common lag", constants::kLagTolerance, true, [](SimParams& p, double d) {
                   for (JointParams& joint : p.joints) joint.command_delay += std::max(0.0, d);
                 }});
  return out;
}

bool Model::has(int candidate) const {
  return std::any_of(effects.begin(), effects.end(), [&](const Chosen& c) { return c.candidate == candidate; });
}

void Library::apply(const Model& model, SimParams& params) const {
  for (std::size_t i = 0; i < model.nuisance.size(); ++i) {
    if (model.nuisance[i] != 0.0) nuisances[i].apply(params, model.nuisance[i]);
  }
  for (const Chosen& c : model.effects) candidates[static_cast<std::size_t>(c.candidate)].apply(params, c.theta);
}

std::string Candidate::title() const {
  std::string text = effect;
  for (std::size_t i = 0; i < where.size(); ++i) text += (i == 0 ? " at " : ", ") + where[i];
  return text;
}

}  // namespace sanso::diagnose
