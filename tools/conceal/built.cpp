// The figures that a data sheet, a scale and a drawing give, and how well they give them.
#include "tools/conceal/built.h"

#include <nlohmann/json.hpp>

namespace sanso::conceal {
namespace {

using nlohmann::json;

/// A figure of a joint that is known to a share of itself.
struct Figure {
  const char* name;
  double JointTruth::*value;
  double tolerance;  // relative
};
constexpr Figure kFigures[] = {
    {"viscous", &JointTruth::viscous, 0.05},
    {"coulomb", &JointTruth::coulomb, 0.05},
    {"p_gain", &JointTruth::p_gain, 0.02},
    {"torque_constant", &JointTruth::torque_constant, 0.02},
    {"back_emf", &JointTruth::back_emf, 0.02},
    {"resistance", &JointTruth::resistance, 0.02},
    {"armature", &JointTruth::armature, 0.1},
};
constexpr double kZero_rad = 0.0015, kLag_s = 0.0005;
constexpr double kNoFriction = 0.001;  // N m: bearings alone

}  // namespace

JointTruth nominal_joint(Random& random) {
  JointTruth joint;
  const double coulomb = random.uniform(0.04, 0.16);
  joint.coulomb = random.chance(0.9) ? coulomb : kNoFriction;
  return joint;
}

Formulas draw_formulas(Random& random) {
  Formulas f;
  const double law = random.uniform();
  f.friction = law < 0.4   ? FrictionLaw::lugre
               : law < 0.7 ? FrictionLaw::dahl
                           : FrictionLaw::arctangent;
  f.fall = random.chance(0.5) ? Fall::gaussian : Fall::lorentzian;
  f.teeth = random.chance(0.5) ? Teeth::linear : Teeth::hertzian;
  f.mailbox = random.chance(0.5) ? Mailbox::at_once : Mailbox::polled;
  return f;
}

json to_json(const Formulas& f) {
  return {{"friction", f.friction == FrictionLaw::lugre  ? "lugre"
                       : f.friction == FrictionLaw::dahl ? "dahl"
                                                         : "arctangent"},
          {"fall", f.fall == Fall::gaussian ? "gaussian" : "lorentzian"},
          {"teeth", f.teeth == Teeth::linear ? "linear" : "hertzian"},
          {"mailbox", f.mailbox == Mailbox::at_once ? "at once" : "polled"}};
}

WorldTruth built_world(const RobotSpec& nominal, const JointTruth& joint, Random& random) {
  WorldTruth world;
  world.robot = as_built(nominal, random);
  const double lag = random.uniform(-kLag_s, kLag_s);  // of the bus: alike for all
  for (std::size_t j = 0; j < nominal.links.size(); ++j) {
    JointTruth built = joint;
    for (const Figure& f : kFigures)
      built.*f.value *= 1 + random.uniform(-f.tolerance, f.tolerance);
    built.offset += random.uniform(-kZero_rad, kZero_rad);
    built.command_delay_s += lag;
    world.joints.push_back(built);
  }
  return world;
}

json tolerances(const WorldTruth& built, const RobotSpec& nominal, const JointTruth& joint) {
  json out;
  for (std::size_t j = 0; j < built.joints.size(); ++j) {
    const LinkSpec &link = built.robot.links[j], &paper = nominal.links[j];
    out["mass"].push_back(link.mass / paper.mass - 1);
    const double length = plant::norm(paper.com);
    out["length"].push_back(length > 0 ? plant::norm(link.com) / length - 1 : 0.0);
    for (const Figure& f : kFigures)
      out[f.name].push_back(built.joints[j].*f.value / (joint.*f.value) - 1);
    out["zero"].push_back(built.joints[j].offset - joint.offset);
    out["lag"].push_back(built.joints[j].command_delay_s - joint.command_delay_s);
  }
  return out;
}

}  // namespace sanso::conceal
