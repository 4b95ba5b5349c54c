// One line an effect; whatever would leave physics (a negative mass) is refused, not clipped.
#include "host/learn/model/named_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/model/joints.h"

namespace sanso::learn {
namespace {

using model::BodyInertia;
using model::ModelParameters;
using model::ServoParameters;

double number(const Numbers& numbers, const char* name, double otherwise) {
  const auto at = numbers.find(name);
  return at == numbers.end() ? otherwise : at->second;
}

bool possible(const ServoParameters& servo) {
  return servo.stiffness > 0.0 && servo.damping >= 0.0 && servo.coulomb >= 0.0 &&
         servo.armature >= 0.0;
}

bool put_gain(ModelParameters& theta, int joint, const Numbers& n) {
  theta.servo[joint].stiffness *= number(n, "gain", 1.0);
  return possible(theta.servo[joint]);
}

bool put_damping(ModelParameters& theta, int joint, const Numbers& n) {
  theta.servo[joint].damping += number(n, "viscous", 0.0);
  return possible(theta.servo[joint]);
}

bool put_dry_friction(ModelParameters& theta, int joint, const Numbers& n) {
  theta.servo[joint].coulomb += number(n, "coulomb", 0.0);
  return possible(theta.servo[joint]);
}

bool put_rotor(ModelParameters& theta, int joint, const Numbers& n) {
  theta.servo[joint].armature += number(n, "armature", 0.0);
  return possible(theta.servo[joint]);
}

bool put_zero(ModelParameters& theta, int joint, const Numbers& n) {
  theta.servo[joint].zero += number(n, "offset", 0.0);
  // of the recording alone: the servo, and so the planner, reads what is right
  return number(n, "of_record", 0.0) == 0.0;
}

/// The model has one lag for all joints: their mean, to which each that is named adds its share.
bool put_lag(ModelParameters& theta, int /*joint*/, const Numbers& n) {
  theta.target_lag_s += number(n, "delay", 0.0) / model::kNumJoints;
  return theta.target_lag_s >= 0.0 && theta.target_lag_s <= model::kLongestTargetLag_s;
}

bool put_mass(ModelParameters& theta, int link, const Numbers& n) {
  BodyInertia& body = theta.body[link];
  const double factor = 1.0 + number(n, "share", 0.0);
  body.mass *= factor;
  for (double& i : body.inertia) i *= factor;
  return body.mass > 0.0;
}

bool put_centre(ModelParameters& theta, int link, const Numbers& n) {
  const char* const axes[3] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) theta.body[link].com[i] += number(n, axes[i], 0.0);
  return theta.body[link].mass > 0.0;
}

/// A point at (x, y, z) in link axes becomes part of the body.
bool put_payload(ModelParameters& theta, int link, const Numbers& n) {
  BodyInertia& body = theta.body[link];
  const double mass = number(n, "mass", 0.0);
  const double r[3] = {number(n, "x", 0.0), number(n, "y", 0.0), number(n, "z", 0.0)};
  const double all = body.mass + mass;
  double d[3];
  for (int i = 0; i < 3; ++i) d[i] = r[i] - body.com[i];
  const double shared = body.mass * mass / all, square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  const int rows[6] = {0, 0, 0, 1, 1, 2}, columns[6] = {0, 1, 2, 1, 2, 2};
  for (int k = 0; k < 6; ++k) {
    const int i = rows[k], j = columns[k];
    body.inertia[k] += shared * ((i == j ? square : 0.0) - d[i] * d[j]);
  }
  for (int i = 0; i < 3; ++i) body.com[i] += mass / all * d[i];
  body.mass = all;
  return body.mass > 0.0;
}

bool put_ground_friction(ModelParameters& theta, int /*ground*/, const Numbers& n) {
  const double mu = number(n, "mu", theta.friction_forward);
  // a foot that rolls has its own ratio of the two
  theta.friction_sideways *= mu / theta.friction_forward;
  theta.friction_forward = mu;
  return mu > 0.0;
}

std::vector<std::string> joint_names() {
  std::vector<std::string> out;
  out.reserve(model::kJoints.size());
  for (const model::JointInfo& joint : model::kJoints) out.emplace_back(joint.name);
  return out;
}

/// Places of `where` in `names`; empty: one of them is none.
std::vector<int> places(const std::vector<std::string>& where,
                        const std::vector<std::string>& names) {
  std::vector<int> out;
  for (const std::string& place : where) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == place) out.push_back(static_cast<int>(i));
  }
  return out.size() == where.size() ? out : std::vector<int>{};
}

std::vector<int> places_of(FigurePlace kind, std::vector<std::string> where) {
  if (kind == FigurePlace::ground) return {0};
  if (kind == FigurePlace::joint) return places(where, joint_names());
  for (std::string& link : where)  // the floating link has many names
    if (link == "base" || link == "base_link" || link == "trunk") link = "body_link";
  return places(where, body_names());
}

}  // namespace

const std::vector<KnownFigure>& known_figures() {
  using enum FigurePlace;
  static const std::vector<KnownFigure> all{
      {"servo_p_gain", joint, {"gain"}, false, put_gain},
      {"viscous_friction", joint, {"viscous"}, false, put_damping},
      {"coulomb_friction", joint, {"coulomb"}, false, put_dry_friction},
      {"rotor_inertia", joint, {"armature"}, false, put_rotor},
      {"encoder_offset", joint, {"offset"}, false, put_zero},
      {"command_delay", joint, {"delay"}, false, put_lag},
      {"link_mass", link, {"share"}, true, put_mass},
      {"link_com", link, {"x", "y", "z"}, false, put_centre},
      {"payload", link, {"mass", "x", "y", "z"}, true, put_payload},
      {"contact_friction", ground, {"mu"}, false, put_ground_friction},
  };
  return all;
}

const KnownFigure* known_figure(std::string_view effect) {
  const auto& all = known_figures();
  const auto at = std::find_if(all.begin(), all.end(),
                               [&](const KnownFigure& known) { return known.effect == effect; });
  return at == all.end() ? nullptr : &*at;
}

std::vector<std::string> body_names() {
  std::vector<std::string> out{"body_link"};
  for (const std::string& joint : joint_names()) out.push_back(joint + "_link");
  return out;
}

std::string put_figure(const NamedFigure& figure, ModelParameters& theta) {
  for (const auto& entry : figure.parameters)
    if (!std::isfinite(entry.second)) return entry.first + " is no number";
  const KnownFigure* known = known_figure(figure.effect);
  if (known == nullptr) return "the planner's model has no figure for it";
  const std::vector<int> at = places_of(known->place, figure.where);
  if (at.empty())
    return fmt::format("its place is no {} of the planner's model",
                       known->place == FigurePlace::joint ? "joint" : "link");
  ModelParameters changed = theta;
  for (const int place : at)
    if (!known->put(changed, place, figure.parameters))
      return "the planner's model cannot take this figure";
  theta = changed;
  return {};
}

}  // namespace sanso::learn
