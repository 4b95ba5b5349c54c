// MJCF. The drive of a DC servo is split: what the controller commands is an actuator with a limit,
// the back-EMF is damping of the joint, because the limit of duty does not limit it.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "tools/diagnose/formats/parts.h"

namespace sanso::diagnose {
namespace {

/// Of element (r, c) in three rows of three.
std::size_t at(Eigen::Index r, Eigen::Index c) { return static_cast<std::size_t>(3 * r + c); }

// Friction of MuJoCo is a soft constraint: as hard as a step of half a millisecond bears. Its
// implicit integrator damps by an actuator's kd at the limit of its force too; Euler does not.
constexpr char kHead[] =
    R"(  <compiler angle="radian" balanceinertia="{}" boundmass="1e-9" boundinertia="1e-12"/>
  <option gravity="{}" timestep="0.0005" integrator="Euler"/>
  <default><joint solreffriction="0.001 1" solimpfriction="0.999 0.9999 0.001"/></default>
)";

std::string inertial(const BodyInertia& body) {
  Eigen::Matrix3d about;
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) about(r, c) = body.about_com[at(r, c)];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(about);
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1.0;
  Mat3 R{};
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) R[at(r, c)] = axes(r, c);
  const Eigen::Vector3d& moments = principal.eigenvalues();
  return fmt::format("<inertial mass=\"{}\" pos=\"{}\" quat=\"{}\" diaginertia=\"{}\"/>",
                     number(body.mass), numbers(body.com), quaternion(R),
                     numbers({moments[0], moments[1], moments[2]}));
}

/// MuJoCo refuses a body whose largest moment exceeds the sum of the others.
bool impossible(const BodyInertia& body) {
  Eigen::Matrix3d about;
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c) about(r, c) = body.about_com[at(r, c)];
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(about).eigenvalues();
  return moments[0] < 0.0 || moments[0] + moments[1] < moments[2] * (1.0 - 1e-9);
}

std::string geom(const Shape& shape) {
  const std::string place =
      fmt::format("pos=\"{}\" quat=\"{}\" contype=\"0\" conaffinity=\"0\" mass=\"0\"",
                  numbers(shape.pose.p), quaternion(shape.pose.R));
  if (const auto box = std::dynamic_pointer_cast<urdf::Box>(shape.geometry))
    return fmt::format("<geom type=\"box\" size=\"{}\" {}/>",
                       numbers({0.5 * box->dim.x, 0.5 * box->dim.y, 0.5 * box->dim.z}), place);
  if (const auto rod = std::dynamic_pointer_cast<urdf::Cylinder>(shape.geometry))
    return fmt::format("<geom type=\"cylinder\" size=\"{} {}\" {}/>", number(rod->radius),
                       number(0.5 * rod->length), place);
  if (const auto ball = std::dynamic_pointer_cast<urdf::Sphere>(shape.geometry))
    return fmt::format("<geom type=\"sphere\" size=\"{}\" {}/>", number(ball->radius), place);
  return {};
}

std::string joint_element(const SimParams& params, std::size_t i) {
  const TreeJoint& joint = params.tree.joints[i];
  const JointParams& p = params.joints[i];
  std::string out = fmt::format(
      "<joint name=\"{}\" type=\"{}\" axis=\"{}\" armature=\"{}\" damping=\"{}\" "
      "frictionloss=\"{}\"",
      joint.name, joint.prismatic ? "slide" : "hinge", numbers(joint.axis),
      number(p.nominal.armature + p.armature),
      number(p.nominal.viscous + p.viscous + linear_servo(params, i).damping),
      number(p.nominal.coulomb + p.coulomb));
  if (p.spring != 0.0)
    out += fmt::format(" stiffness=\"{}\" springref=\"{}\"", number(p.spring),
                       number(p.spring_torque / p.spring));
  // the simulator here knows no limits; they are there to be switched on
  if (joint.lower < joint.upper)
    out +=
        fmt::format(" limited=\"false\" range=\"{} {}\"", number(joint.lower), number(joint.upper));
  return out + "/>";
}

std::string bodies(const Parts& parts, int parent, const std::string& indent) {
  std::string out;
  for (const Shape& shape : parts.shapes)
    if (shape.joint == parent && !geom(shape).empty()) out += indent + geom(shape) + "\n";
  const RobotTree& tree = parts.params.tree;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const TreeJoint& joint = tree.joints[i];
    if (joint.parent != parent) continue;
    out += fmt::format("{0}<body name=\"{1}\" pos=\"{2}\" quat=\"{3}\">\n{0}  {4}\n{0}  {5}\n{6}",
                       indent, joint.link, numbers(joint.p_parent_joint),
                       quaternion(joint.R_parent_joint), inertial(joint.body),
                       joint_element(parts.params, i),
                       bodies(parts, static_cast<int>(i), indent + "  "));
    out += indent + "</body>\n";
  }
  return out;
}

std::string actuators(const SimParams& params) {
  std::string out;
  for (std::size_t i = 0; i < params.joints.size(); ++i) {
    if (params.joints[i].nominal.actuator == Actuator::passive) continue;
    const LinearServo servo = linear_servo(params, i);
    const bool goal = params.joints[i].nominal.actuator != Actuator::torque;
    out += fmt::format(
        "    <general name=\"{0}\" joint=\"{0}\" gainprm=\"{1}\" biastype=\"{2}\" "
        "biasprm=\"0 {3} {4}\"",
        params.tree.joints[i].name, number(goal ? servo.kp : servo.gain), goal ? "affine" : "none",
        number(-servo.kp), number(-servo.kd));
    if (servo.limit < kNone)
      out += fmt::format(" forcelimited=\"true\" forcerange=\"{} {}\"", number(-servo.limit),
                         number(servo.limit));
    out += "/>\n";
  }
  return out.empty() ? out : "  <actuator>\n" + out + "  </actuator>\n";
}

}  // namespace

Exported mjcf_of(const ModelFolder& model) {
  const Parts parts = parts_of(model);
  Exported out{{}, lost_in(kMjcf, parts.params)};
  bool balance = false;
  for (const TreeJoint& joint : parts.params.tree.joints) {
    if (!impossible(joint.body)) continue;
    balance = true;
    out.lost.push_back(fmt::format(
        "rotational inertia of {}: no body has these moments, MuJoCo evens them out", joint.link));
  }
  for (const Shape& shape : parts.shapes)
    if (geom(shape).empty()) {
      out.lost.emplace_back("meshes: shapes that are no box, cylinder or sphere");
      break;
    }
  for (const JointParams& joint : parts.params.joints)
    if (joint.nominal.actuator == Actuator::dc_servo) {
      out.lost.emplace_back(
          "coasting: a servo that is off keeps its back-EMF here, as damping of the joint");
      break;
    }
  out.text = fmt::format("<mujoco model=\"{}\">\n{}", parts.params.tree.name,
                         head_comment("A model of sanso. Controls are goals in rad (m), or "
                                      "torques in N m (N).",
                                      out.lost));
  out.text += fmt::format(kHead, balance, numbers(parts.params.gravity));
  out.text += "  <worldbody>\n" + bodies(parts, -1, "    ") + "  </worldbody>\n" +
              actuators(parts.params) + "</mujoco>\n";
  return out;
}

}  // namespace sanso::diagnose
