// One function an effect; whatever would leave physics (a negative mass) is refused, not clipped.
#include "host/learn/model/named_figures.h"

#include <cmath>
#include <functional>

#include "shared/model/joints.h"

namespace sanso::learn {
namespace {

using model::BodyInertia;
using model::ModelParameters;
using model::ServoParameters;
using Numbers = std::map<std::string, double>;

double number(const Numbers& numbers, const char* name, double otherwise) {
  const auto at = numbers.find(name);
  return at == numbers.end() ? otherwise : at->second;
}

void scale(BodyInertia& body, double factor) {
  body.mass *= factor;
  for (double& i : body.inertia) i *= factor;
}

/// A point at r in link axes becomes part of the body.
void carry(BodyInertia& body, double mass, const double r[3]) {
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
}

/// What an effect does to one servo; false: a figure that no servo has.
bool put_servo(const std::string& effect, const Numbers& n, ServoParameters& servo) {
  if (effect == "servo_p_gain") servo.stiffness *= number(n, "gain", 1.0);
  if (effect == "viscous_friction") servo.damping += number(n, "viscous", 0.0);
  if (effect == "coulomb_friction") servo.coulomb += number(n, "coulomb", 0.0);
  if (effect == "rotor_inertia") servo.armature += number(n, "armature", 0.0);
  return servo.stiffness > 0.0 && servo.damping >= 0.0 && servo.coulomb >= 0.0 &&
         servo.armature >= 0.0;
}

bool put_body(const std::string& effect, const Numbers& n, BodyInertia& body) {
  const double at[3] = {number(n, "x", 0.0), number(n, "y", 0.0), number(n, "z", 0.0)};
  if (effect == "link_mass") scale(body, 1.0 + number(n, "share", 0.0));
  if (effect == "link_com")
    for (int i = 0; i < 3; ++i) body.com[i] += at[i];
  if (effect == "payload") carry(body, number(n, "mass", 0.0), at);
  return body.mass > 0.0;
}

bool one_of(const std::string& effect, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (effect == name) return true;
  return false;
}

/// Places of the figure in `names`; empty: one of them is none.
std::vector<int> places(const std::vector<std::string>& where,
                        const std::vector<std::string>& names) {
  std::vector<int> out;
  for (const std::string& place : where) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == place) out.push_back(static_cast<int>(i));
  }
  return out.size() == where.size() ? out : std::vector<int>{};
}

std::vector<std::string> joint_names() {
  std::vector<std::string> out;
  out.reserve(model::kJoints.size());
  for (const model::JointInfo& joint : model::kJoints) out.emplace_back(joint.name);
  return out;
}

}  // namespace

std::vector<std::string> body_names() {
  std::vector<std::string> out{"body_link"};
  for (const std::string& joint : joint_names()) out.push_back(joint + "_link");
  return out;
}

std::string put_figure(const NamedFigure& figure, ModelParameters& theta) {
  for (const auto& entry : figure.parameters)
    if (!std::isfinite(entry.second)) return entry.first + " is no number";
  ModelParameters changed = theta;
  bool fine = true;
  if (one_of(figure.effect,
             {"servo_p_gain", "viscous_friction", "coulomb_friction", "rotor_inertia"})) {
    const std::vector<int> joints = places(figure.where, joint_names());
    if (joints.empty()) return "its place is no joint of the planner's model";
    for (const int j : joints)
      fine = fine && put_servo(figure.effect, figure.parameters, changed.servo[j]);
  } else if (one_of(figure.effect, {"link_mass", "link_com", "payload"})) {
    std::vector<std::string> where = figure.where;
    for (std::string& link : where)  // the floating link has many names
      if (link == "base" || link == "base_link" || link == "trunk") link = "body_link";
    const std::vector<int> bodies = places(where, body_names());
    if (bodies.empty()) return "its place is no link of the planner's model";
    for (const int b : bodies)
      fine = fine && put_body(figure.effect, figure.parameters, changed.body[b]);
  } else if (figure.effect == "contact_friction") {
    const double mu = number(figure.parameters, "mu", theta.friction_forward);
    // a foot that rolls has its own ratio of the two
    changed.friction_sideways *= mu / theta.friction_forward;
    changed.friction_forward = mu;
    fine = mu > 0.0;
  } else {
    return "the planner's model has no figure for it";
  }
  if (!fine) return "the figure would leave physics";
  theta = changed;
  return {};
}

}  // namespace sanso::learn
