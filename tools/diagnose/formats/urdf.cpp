// URDF: links that were merged come back as frames without mass, with their shapes where they were.
#include <fmt/format.h>

#include "tools/diagnose/formats/parts.h"

namespace sanso::diagnose {
namespace {

std::string origin(const Pose& pose) {
  return fmt::format("<origin xyz=\"{}\" rpy=\"{}\"/>", numbers(pose.p), roll_pitch_yaw(pose.R));
}

std::string geometry(const urdf::Geometry& shape) {
  if (const auto* box = dynamic_cast<const urdf::Box*>(&shape))
    return fmt::format("<box size=\"{}\"/>", numbers({box->dim.x, box->dim.y, box->dim.z}));
  if (const auto* rod = dynamic_cast<const urdf::Cylinder*>(&shape))
    return fmt::format("<cylinder radius=\"{}\" length=\"{}\"/>", number(rod->radius),
                       number(rod->length));
  if (const auto* ball = dynamic_cast<const urdf::Sphere*>(&shape))
    return fmt::format("<sphere radius=\"{}\"/>", number(ball->radius));
  const auto& mesh = dynamic_cast<const urdf::Mesh&>(shape);
  return fmt::format("<mesh filename=\"{}\" scale=\"{}\"/>", mesh.filename,
                     numbers({mesh.scale.x, mesh.scale.y, mesh.scale.z}));
}

std::string visuals(const Parts& parts, int joint) {
  std::string out;
  for (const Shape& shape : parts.shapes)
    if (shape.joint == joint)
      out += fmt::format("    <visual>{}<geometry>{}</geometry></visual>\n", origin(shape.pose),
                         geometry(*shape.geometry));
  return out;
}

std::string link(const Parts& parts, int index) {
  if (index < 0)
    return fmt::format("  <link name=\"{}\">\n{}  </link>\n", parts.root, visuals(parts, index));
  const TreeJoint& joint = parts.params.tree.joints[static_cast<std::size_t>(index)];
  const Mat3& I = joint.body.about_com;
  return fmt::format(
      "  <link name=\"{}\">\n    <inertial><origin xyz=\"{}\"/><mass value=\"{}\"/><inertia "
      "ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial>\n{}"
      "  </link>\n",
      joint.link, numbers(joint.body.com), number(joint.body.mass), number(I[0]), number(I[1]),
      number(I[2]), number(I[4]), number(I[5]), number(I[8]), visuals(parts, index));
}

std::string limits(const TreeJoint& joint, const LinearServo& servo) {
  constexpr double kMany = 1000.0;  // where the model gives none; the format demands a number
  const double effort = joint.effort > 0.0    ? joint.effort
                        : servo.limit < kNone ? servo.limit
                                              : kMany;
  const std::string range =
      joint.lower < joint.upper
          ? fmt::format("lower=\"{}\" upper=\"{}\" ", number(joint.lower), number(joint.upper))
          : "";
  return fmt::format("<limit {}effort=\"{}\" velocity=\"{}\"/>", range, number(effort),
                     number(joint.speed > 0.0 ? joint.speed : kMany));
}

std::string moving_joint(const Parts& parts, std::size_t i) {
  const TreeJoint& joint = parts.params.tree.joints[i];
  const JointParams& p = parts.params.joints[i];
  const char* turning = joint.lower < joint.upper ? "revolute" : "continuous";
  return fmt::format(
      "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/><child link=\"{}\"/>{}"
      "<axis xyz=\"{}\"/>\n    <dynamics damping=\"{}\" friction=\"{}\"/>{}\n  </joint>\n",
      joint.name, joint.prismatic ? "prismatic" : turning, link_name(parts, joint.parent),
      joint.link, origin({joint.R_parent_joint, joint.p_parent_joint}), numbers(joint.axis),
      number(p.nominal.viscous + p.viscous), number(p.nominal.coulomb + p.coulomb),
      limits(joint, linear_servo(parts.params, i)));
}

}  // namespace

Exported urdf_of(const ModelFolder& model) {
  const Parts parts = parts_of(model);
  const RobotTree& tree = parts.params.tree;
  Exported out{{}, lost_in(kUrdf, parts.params)};
  out.text = fmt::format("<?xml version=\"1.0\"?>\n{}<robot name=\"{}\">\n{}",
                         head_comment("A model of sanso, with its effects.", out.lost), tree.name,
                         link(parts, -1));
  for (std::size_t i = 0; i < tree.size(); ++i) out.text += link(parts, static_cast<int>(i));
  for (std::size_t i = 0; i < tree.joints.size(); ++i) out.text += moving_joint(parts, i);
  for (const auto& [name, place] : tree.links) {
    const std::string parent = link_name(parts, place.joint);
    if (name == parent) continue;
    out.text += fmt::format(
        "  <link name=\"{0}\"/>\n  <joint name=\"{0}_fixed\" type=\"fixed\"><parent link=\"{1}\"/>"
        "<child link=\"{0}\"/>{2}</joint>\n",
        name, parent, origin({place.R_joint_link, place.p_joint_link}));
  }
  out.text += "</robot>\n";
  return out;
}

}  // namespace sanso::diagnose
