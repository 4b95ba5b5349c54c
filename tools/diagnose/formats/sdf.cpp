// SDF 1.7: one link a joint, fixed to the world at the root; merged links are frames.
#include <fmt/format.h>

#include <set>

#include "tools/diagnose/formats/parts.h"

namespace sanso::diagnose {
namespace {

// A link without mass or inertia is none for SDF's readers.
constexpr double kLeastMass_kg = 1e-6, kLeastInertia_kgm2 = 1e-9;

std::string pose(const Pose& of, const std::string& in) {
  const std::string relative = in.empty() ? "" : fmt::format(" relative_to=\"{}\"", in);
  return fmt::format("<pose{}>{} {}</pose>", relative, numbers(of.p), roll_pitch_yaw(of.R));
}

std::string geometry(const urdf::Geometry& shape) {
  if (const auto* box = dynamic_cast<const urdf::Box*>(&shape))
    return fmt::format("<box><size>{}</size></box>", numbers({box->dim.x, box->dim.y, box->dim.z}));
  if (const auto* rod = dynamic_cast<const urdf::Cylinder*>(&shape))
    return fmt::format("<cylinder><radius>{}</radius><length>{}</length></cylinder>",
                       number(rod->radius), number(rod->length));
  if (const auto* ball = dynamic_cast<const urdf::Sphere*>(&shape))
    return fmt::format("<sphere><radius>{}</radius></sphere>", number(ball->radius));
  const auto& mesh = dynamic_cast<const urdf::Mesh&>(shape);
  return fmt::format("<mesh><uri>{}</uri><scale>{}</scale></mesh>", mesh.filename,
                     numbers({mesh.scale.x, mesh.scale.y, mesh.scale.z}));
}

std::string visuals(const Parts& parts, int joint) {
  std::string out;
  int count = 0;
  for (const Shape& shape : parts.shapes)
    if (shape.joint == joint)
      out += fmt::format("      <visual name=\"visual_{}\">{}<geometry>{}</geometry></visual>\n",
                         ++count, pose(shape.pose, ""), geometry(*shape.geometry));
  return out;
}

std::string inertial(const BodyInertia& body) {
  const Mat3& I = body.about_com;
  const auto moment = [](double v) { return number(std::max(v, kLeastInertia_kgm2)); };
  return fmt::format(
      "      <inertial>{}<mass>{}</mass><inertia><ixx>{}</ixx><ixy>{}</ixy><ixz>{}</ixz>"
      "<iyy>{}</iyy><iyz>{}</iyz><izz>{}</izz></inertia></inertial>\n",
      pose({kIdentity3, body.com}, ""), number(std::max(body.mass, kLeastMass_kg)), moment(I[0]),
      number(I[1]), number(I[2]), moment(I[4]), number(I[5]), moment(I[8]));
}

std::string dynamics(const JointParams& p) {
  std::string out =
      fmt::format("<damping>{}</damping><friction>{}</friction>",
                  number(p.nominal.viscous + p.viscous), number(p.nominal.coulomb + p.coulomb));
  if (p.spring != 0.0)
    out += fmt::format(
        "<spring_reference>{}</spring_reference><spring_stiffness>{}</spring_stiffness>",
        number(p.spring_torque / p.spring), number(p.spring));
  return "<dynamics>" + out + "</dynamics>";
}

std::string link_and_joint(const Parts& parts, std::size_t i, const std::string& joint_name) {
  const TreeJoint& joint = parts.params.tree.joints[i];
  const std::string parent = link_name(parts, joint.parent);
  std::string limit;
  if (joint.lower < joint.upper)
    limit = fmt::format("<limit><lower>{}</lower><upper>{}</upper></limit>", number(joint.lower),
                        number(joint.upper));
  const char* turning = joint.lower < joint.upper ? "revolute" : "continuous";
  return fmt::format(
      "    <link name=\"{0}\">\n      {1}\n{2}{3}    </link>\n"
      "    <joint name=\"{4}\" type=\"{5}\">\n"
      "      <parent>{6}</parent><child>{0}</child>\n      <axis><xyz>{7}</xyz>{8}{9}</axis>\n"
      "    </joint>\n",
      joint.link, pose({joint.R_parent_joint, joint.p_parent_joint}, parent), inertial(joint.body),
      visuals(parts, static_cast<int>(i)), joint_name, joint.prismatic ? "prismatic" : turning,
      parent, numbers(joint.axis), limit, dynamics(parts.params.joints[i]));
}

}  // namespace

Exported sdf_of(const ModelFolder& model) {
  const Parts parts = parts_of(model);
  const RobotTree& tree = parts.params.tree;
  Exported out{{}, lost_in(kSdf, parts.params)};
  for (const TreeJoint& joint : tree.joints)
    if (joint.body.mass < kLeastMass_kg)
      out.lost.push_back(fmt::format("that {} has no mass: SDF demands some", joint.link));
  std::string body = fmt::format(
      "    <link name=\"{0}\">\n{1}    </link>\n    <joint name=\"sanso_base\" type=\"fixed\">"
      "<parent>world</parent><child>{0}</child></joint>\n",
      parts.root, visuals(parts, -1));
  for (std::size_t i = 0; i < tree.joints.size(); ++i) {
    std::string name = tree.joints[i].name;  // links and joints share their names' space in SDF
    if (tree.links.count(name) > 0) {
      name += "_joint";
      out.lost.push_back(
          fmt::format("the name of joint {}, a link's too: {} here", tree.joints[i].name, name));
    }
    body += link_and_joint(parts, i, name);
  }
  for (const auto& [name, place] : tree.links) {
    const std::string parent = link_name(parts, place.joint);
    if (name == parent) continue;
    body += fmt::format("    <frame name=\"{}\" attached_to=\"{}\">{}</frame>\n", name, parent,
                        pose({place.R_joint_link, place.p_joint_link}, ""));
  }
  out.text =
      fmt::format("<?xml version=\"1.0\"?>\n{}<sdf version=\"1.7\">\n  <model name=\"{}\">\n",
                  head_comment("A model of sanso, with its effects.", out.lost), tree.name);
  out.text += body + "  </model>\n</sdf>\n";
  return out;
}

}  // namespace sanso::diagnose
