// URDF and model.toml are written as text and read as any other: one reader for all models.
#include "tools/diagnose/run/planner_model.h"

#include <fmt/format.h>

#include "shared/model/joints.h"

namespace sanso::diagnose {
namespace {

constexpr double kSoleThickness = 0.004;  // m; of the drawing, the lower face counts

std::string link_name(int body) {
  return body == 0 ? "body_link"
                   : std::string(model::kJoints[static_cast<std::size_t>(body - 1)].name) + "_link";
}

/// Joint j carries body j + 1; both legs begin at the base.
int parent_of(int joint) { return joint % 6 == 0 ? 0 : joint; }

std::string sole(const model::FootShape& foot, bool left) {
  return fmt::format(
      "<collision><origin xyz=\"{:.17g} {:.17g} {:.17g}\"/><geometry>"
      "<box size=\"{:.17g} {:.17g} {:.17g}\"/></geometry></collision>",
      model::kSoleCentreX, left ? model::kSoleCentreY : -model::kSoleCentreY,
      foot.height + 0.5 * kSoleThickness, 2 * foot.half_length, 2 * foot.half_width,
      kSoleThickness);
}

std::string link_text(const model::ModelParameters& theta, int body) {
  const model::BodyInertia& b = theta.body[body];
  return fmt::format(
      "<link name=\"{}\"><inertial><origin xyz=\"{:.17g} {:.17g} {:.17g}\"/>"
      "<mass value=\"{:.17g}\"/><inertia ixx=\"{:.17g}\" ixy=\"{:.17g}\" ixz=\"{:.17g}\" "
      "iyy=\"{:.17g}\" iyz=\"{:.17g}\" izz=\"{:.17g}\"/></inertial>{}</link>\n",
      link_name(body), b.com[0], b.com[1], b.com[2], b.mass, b.inertia[0], b.inertia[1],
      b.inertia[2], b.inertia[3], b.inertia[4], b.inertia[5],
      body == 6 || body == 12 ? sole(theta.foot, body == 12) : "");
}

std::string joint_text(const model::ModelParameters& theta, int joint) {
  const model::JointGeometry& g = model::kOp3Joints[joint];
  const model::JointInfo& info = model::kJoints[static_cast<std::size_t>(joint)];
  int axis[3] = {0, 0, 0};
  axis[g.axis] = g.sign;
  return fmt::format(
      "<joint name=\"{}\" type=\"revolute\"><parent link=\"{}\"/><child link=\"{}\"/>"
      "<origin xyz=\"{:.17g} {:.17g} {:.17g}\"/><axis xyz=\"{} {} {}\"/>"
      "<limit lower=\"{:.17g}\" upper=\"{:.17g}\" effort=\"{:.17g}\" velocity=\"5\"/></joint>\n",
      info.name, link_name(parent_of(joint)), link_name(joint + 1), g.origin[0], g.origin[1],
      g.origin[2], axis[0], axis[1], axis[2], info.lower_rad, info.upper_rad,
      theta.servo[joint].torque_limit);
}

std::string drive_text(const model::ModelParameters& theta, int joint) {
  const model::ServoParameters& s = theta.servo[joint];
  return fmt::format(
      "[joint.{}]\nactuator = \"position_pd\"\nkp = {:.17g}\nkd = {:.17g}\narmature = {:.17g}\n"
      "coulomb = {:.17g}\ntorque_limit = {:.17g}\n",
      model::kJoints[static_cast<std::size_t>(joint)].name, s.stiffness, s.damping, s.armature,
      s.coulomb, s.torque_limit);
}

}  // namespace

std::string planner_urdf(const model::ModelParameters& theta) {
  std::string out = "<?xml version=\"1.0\"?>\n<robot name=\"op3\">\n";
  for (int body = 0; body < model::kNumBodies; ++body) out += link_text(theta, body);
  for (int joint = 0; joint < model::kNumJoints; ++joint) out += joint_text(theta, joint);
  return out + "</robot>\n";
}

WholeBody planner_body(const model::ModelParameters& theta) {
  std::string toml = fmt::format(
      "format = 1\n[robot]\nurdf = \"robot.urdf\"\nbase = \"floating\"\n[control]\n"
      "period_s = 0.01\n[ground]\nfriction = {:.17g}\n",
      theta.friction_forward);
  for (int joint = 0; joint < model::kNumJoints; ++joint) toml += drive_text(theta, joint);
  return parse_whole_body(toml, planner_urdf(theta), "model.toml");
}

}  // namespace sanso::diagnose
