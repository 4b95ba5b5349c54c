// The three robots as tables, their scatter as built, and the two texts written from them.
#include "tools/conceal/robot_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tools/plant/body_data.h"
#include "tools/plant/world_error.h"

namespace sanso::conceal {

using plant::operator+;
using plant::operator*;
using plant::cross;
using plant::dot;
using plant::norm;

namespace {

/// A rod along -z with a weight at its end.
LinkSpec rod(const std::string& link, const std::string& joint, double rod_kg, double length_m,
             double tip_kg) {
  LinkSpec l;
  l.link = link;
  l.joint = joint;
  l.mass = rod_kg + tip_kg;
  const double z = -(0.5 * rod_kg + tip_kg) * length_m / l.mass;
  l.com = {0, 0, z};
  const double about_joint = rod_kg * length_m * length_m / 3 + tip_kg * length_m * length_m;
  l.inertia[0] = l.inertia[1] = about_joint - l.mass * z * z + 2e-6;
  l.inertia[2] = 4e-5;
  l.payload_at = {0, 0, -length_m};
  return l;
}

RobotSpec pendulum() {
  RobotSpec robot;
  robot.name = "pendulum";
  robot.links = {rod("rod", "pivot", 0.10, 0.15, 0.25)};
  robot.amplitude_rad = 1.0;
  robot.payload_kg = 0.15;
  robot.posture = {0.0};
  return robot;
}

RobotSpec arm() {
  RobotSpec robot;
  robot.name = "arm";
  robot.links = {rod("upper_arm", "shoulder", 0.12, 0.16, 0.10),
                 rod("forearm", "elbow", 0.08, 0.13, 0.10)};
  robot.links[1].parent = 0;
  robot.links[1].origin = {0, 0, -0.16};
  robot.amplitude_rad = 0.7;
  robot.payload_kg = 0.12;
  robot.payload_link = 1;
  robot.posture = {0.2, 0.4};
  return robot;
}

RobotSpec op3_stand() {
  RobotSpec robot;
  robot.name = "op3-stand";
  robot.amplitude_rad = 0.35;
  const auto& body = plant::op3_body();
  std::map<std::string, int> index;
  for (const char* side : {"r", "l"}) {
    for (const char* part : {"hip_yaw", "hip_roll", "hip_pitch", "knee", "ank_pitch", "ank_roll"}) {
      const std::string name = fmt::format("{}_{}", side, part);
      const auto joint = std::find_if(body.joints.begin(), body.joints.end(),
                                      [&](auto& j) { return j.name == name; });
      const auto link = std::find_if(body.links.begin(), body.links.end(),
                                     [&](auto& l) { return l.name == joint->child; });
      LinkSpec l;
      l.link = link->name;
      l.joint = name;
      l.parent = index.contains(joint->parent) ? index[joint->parent] : -1;
      l.origin = joint->origin_m;
      l.axis = joint->axis;
      l.mass = link->mass_kg;
      l.com = link->com_m;
      const double inertia[6] = {link->ixx, link->iyy, link->izz, link->ixy, link->ixz, link->iyz};
      std::copy(inertia, inertia + 6, l.inertia);
      l.payload_at = link->com_m;
      index[l.link] = static_cast<int>(robot.links.size());
      robot.links.push_back(l);
      const bool knee = name.ends_with("knee");
      robot.posture.push_back(knee ? (side[0] == 'r' ? -0.5 : 0.5) : 0.0);
    }
  }
  return robot;
}

void write_body(std::string& out, const RobotSpec& robot, const std::vector<double>& armature,
                int index) {
  const LinkSpec& l = robot.links[static_cast<std::size_t>(index)];
  const double* i = l.inertia;
  out += fmt::format(
      R"(<body name="{0}" pos="{1}"><joint name="{2}" type="hinge" axis="{3}" armature="{4:.9g}"/>)"
      R"(<inertial pos="{5}" mass="{6:.9g}" fullinertia="{7:.9g} {8:.9g} {9:.9g} {10:.9g} )"
      R"({11:.9g} {12:.9g}"/>)"
      R"(<body name="{0}_payload" pos="{13}"><inertial pos="0 0 0" mass="1e-9" diaginertia="1e-12 )"
      R"(1e-12 1e-12"/></body>)",
      l.link, text(l.origin), l.joint, text(l.axis), armature[static_cast<std::size_t>(index)],
      text(l.com), l.mass, i[0], i[1], i[2], i[3], i[4], i[5], text(l.payload_at));
  for (int child = 0; child < robot.size(); ++child) {
    if (robot.links[static_cast<std::size_t>(child)].parent == index)
      write_body(out, robot, armature, child);
  }
  out += "</body>\n";
}

}  // namespace

std::string text(const Vec3& v) { return fmt::format("{:.9g} {:.9g} {:.9g}", v[0], v[1], v[2]); }

Vec3 direction(Random& random) {
  const Vec3 v{random.normal(), random.normal(), random.normal()};
  return (1.0 / std::max(plant::norm(v), 1e-9)) * v;
}

RobotSpec make_robot(const std::string& name) {
  if (name == "pendulum") return pendulum();
  if (name == "arm") return arm();
  if (name == "op3-stand") return op3_stand();
  throw plant::WorldError("robot '" + name + "': expected pendulum, arm, op3-stand or op3-floor");
}

RobotSpec as_built(const RobotSpec& nominal, Random& random) {
  RobotSpec built = nominal;
  for (LinkSpec& link : built.links) {
    const double mass = 1 + random.uniform(-0.03, 0.03), length = 1 + random.uniform(-0.02, 0.02);
    link.mass *= mass;
    link.com = length * link.com;
    for (double& i : link.inertia) i *= mass * length * length;
  }
  return built;
}

std::string to_urdf(const RobotSpec& robot) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n  <link name=\"base\"/>\n", robot.name);
  for (const LinkSpec& l : robot.links) {
    const double* i = l.inertia;
    const std::string parent =
        l.parent < 0 ? "base" : robot.links[static_cast<std::size_t>(l.parent)].link;
    out += fmt::format(
        "  <link name=\"{}\">\n    <inertial>\n      <origin xyz=\"{}\"/>\n      <mass "
        "value=\"{:.9g}\"/>\n"
        "      <inertia ixx=\"{:.9g}\" iyy=\"{:.9g}\" izz=\"{:.9g}\" ixy=\"{:.9g}\" "
        "ixz=\"{:.9g}\" iyz=\"{:.9g}\"/>\n"
        "    </inertial>\n  </link>\n",
        l.link, text(l.com), l.mass, i[0], i[1], i[2], i[3], i[4], i[5]);
    out += fmt::format(
        "  <joint name=\"{}\" type=\"revolute\">\n    <parent link=\"{}\"/>\n    <child "
        "link=\"{}\"/>\n"
        "    <origin xyz=\"{}\"/>\n    <axis xyz=\"{}\"/>\n"
        "    <limit lower=\"{}\" upper=\"{}\" effort=\"4.1\" velocity=\"4.82\"/>\n  </joint>\n",
        l.joint, parent, l.link, text(l.origin), text(l.axis), l.lower, l.upper);
  }
  return out + "</robot>\n";
}

std::string to_mjcf(const RobotSpec& robot, const std::vector<double>& armature, double step_s,
                    const Vec3& gravity) {
  std::string out = fmt::format(R"(<mujoco model="{}">
<compiler angle="radian" boundmass="1e-9" boundinertia="1e-12"/>
<option timestep="{}" gravity="{}" integrator="Euler">
<flag contact="disable" constraint="disable"/></option>
<worldbody>
)",
                                robot.name, step_s, text(gravity));
  for (int i = 0; i < robot.size(); ++i) {
    if (robot.links[static_cast<std::size_t>(i)].parent < 0) write_body(out, robot, armature, i);
  }
  return out + "</worldbody>\n</mujoco>\n";
}

void add_axis_inertia(LinkSpec& link, double share) {
  // two equal point masses on a line n through the COM, n across the axis: inertia m r^2 (1 - n n')
  // in all
  const Vec3 a = (1.0 / norm(link.axis)) * link.axis;
  const Vec3 helper = std::abs(a[0]) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 0, 1};
  Vec3 n = cross(a, helper);
  n = (1.0 / norm(n)) * n;
  const double* i = link.inertia;
  const double about_com = a[0] * a[0] * i[0] + a[1] * a[1] * i[1] + a[2] * a[2] * i[2] +
                           2 * (a[0] * a[1] * i[3] + a[0] * a[2] * i[4] + a[1] * a[2] * i[5]);
  const Vec3 lever = cross(a, link.com);
  const double added = share * (about_com + link.mass * dot(lever, lever));
  link.inertia[0] += added * (1 - n[0] * n[0]);
  link.inertia[1] += added * (1 - n[1] * n[1]);
  link.inertia[2] += added * (1 - n[2] * n[2]);
  link.inertia[3] -= added * n[0] * n[1];
  link.inertia[4] -= added * n[0] * n[2];
  link.inertia[5] -= added * n[1] * n[2];
}

}  // namespace sanso::conceal
