// Effects are applied by the library itself, so that a format holds what the simulator simulates.
#include "tools/diagnose/formats/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/effects/from_model.h"

namespace sanso::diagnose {
namespace {

Pose pose_of(const urdf::Pose& pose) {
  double x = 0, y = 0, z = 0, w = 1;
  pose.rotation.getQuaternion(x, y, z, w);
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
           1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x),
           1 - 2 * (x * x + y * y)},
          {pose.position.x, pose.position.y, pose.position.z}};
}

std::vector<Shape> shapes_of(const urdf::ModelInterface& robot, const RobotTree& tree) {
  std::vector<Shape> out;
  for (const auto& [name, link] : robot.links_) {
    const auto place = tree.links.find(name);
    if (place == tree.links.end()) continue;
    const Pose of_link{place->second.R_joint_link, place->second.p_joint_link};
    for (const auto& visual : link->visual_array)
      if (visual && visual->geometry)
        out.push_back({place->second.joint, of_link * pose_of(visual->origin), visual->geometry});
  }
  return out;
}

double at_most(double limit) { return limit > 0.0 ? limit : kNone; }

}  // namespace

std::string link_name(const Parts& parts, int joint) {
  return joint < 0 ? parts.root : parts.params.tree.joints[static_cast<std::size_t>(joint)].link;
}

Pose operator*(const Pose& a, const Pose& b) {
  return {product(a.R, b.R), a.p + rotated(a.R, b.p)};
}

Parts parts_of(const ModelFolder& model) {
  require_fixed_base(model, "sanso export");
  Parts parts{params_with_effects(model), {}, {}};
  for (const LatePayload& payload : parts.params.late_payloads)
    if (payload.from_s <= 0.0 && payload.joint >= 0)
      add_body(parts.params.tree.joints[static_cast<std::size_t>(payload.joint)].body,
               payload.body);
  std::erase_if(parts.params.late_payloads, [](const LatePayload& p) { return p.from_s <= 0.0; });
  const urdf::ModelInterfaceSharedPtr robot =
      model::parse_urdf_text(model.urdf, model.folder + "/" + model.urdf_file);
  parts.root = robot->getRoot()->name;
  parts.shapes = shapes_of(*robot, parts.params.tree);
  return parts;
}

std::string head_comment(const std::string& what, const std::vector<std::string>& lost) {
  std::string out = "<!-- " + what + "\n";
  if (!lost.empty()) out += "     Not in this file:\n";
  for (std::string line : lost) {
    for (std::size_t at = line.find("--"); at != std::string::npos; at = line.find("--"))
      line.replace(at, 2, "- ");  // would end the comment
    out += "     - " + line + "\n";
  }
  return out + "-->\n";
}

std::string number(double value) { return fmt::format("{:.17g}", value); }
std::string numbers(const Vec3& v) {
  return number(v[0]) + " " + number(v[1]) + " " + number(v[2]);
}

std::string quaternion(const Mat3& R) {
  // the largest of the four is found first, so that nothing is divided by little
  const double traces[4] = {R[0] + R[4] + R[8], R[0] - R[4] - R[8], R[4] - R[0] - R[8],
                            R[8] - R[0] - R[4]};
  const auto k = std::max_element(traces, traces + 4) - traces;
  const double s = std::sqrt(1.0 + traces[k]), h = 0.5 / s;
  double q[4] = {0.5 * s, (R[7] - R[5]) * h, (R[2] - R[6]) * h, (R[3] - R[1]) * h};
  if (k == 1)
    q[0] = (R[7] - R[5]) * h, q[1] = 0.5 * s, q[2] = (R[1] + R[3]) * h, q[3] = (R[2] + R[6]) * h;
  if (k == 2)
    q[0] = (R[2] - R[6]) * h, q[1] = (R[1] + R[3]) * h, q[2] = 0.5 * s, q[3] = (R[5] + R[7]) * h;
  if (k == 3)
    q[0] = (R[3] - R[1]) * h, q[1] = (R[2] + R[6]) * h, q[2] = (R[5] + R[7]) * h, q[3] = 0.5 * s;
  return fmt::format("{} {} {} {}", number(q[0]), number(q[1]), number(q[2]), number(q[3]));
}

std::string roll_pitch_yaw(const Mat3& R) {
  constexpr double kUpright = 1e-9;  // beyond it roll and yaw turn about one axis
  const double level = std::hypot(R[0], R[3]);
  const double pitch = std::atan2(-R[6], level);
  if (level < kUpright) return numbers({0.0, pitch, std::atan2(-R[1], R[4])});
  return numbers({std::atan2(R[7], R[8]), pitch, std::atan2(R[3], R[0])});
}

LinearServo linear_servo(const SimParams& params, std::size_t joint) {
  const JointParams& j = params.joints[joint];
  const JointSettings& s = j.nominal;
  const double supply = 1.0 + params.supply_level;
  LinearServo out;
  if (s.actuator == Actuator::dc_servo) {
    const double torque_constant = s.torque_constant * j.torque_scale;
    const double resistance = s.resistance * j.resistance_scale;
    const double stall = torque_constant * s.voltage * supply / resistance;
    const double stated = j.stated_voltage > 0.0 ? j.stated_voltage : s.voltage;
    const double nominal_stall = s.torque_constant * stated / s.resistance;
    const double added = nominal_stall > 0.0 ? j.d_torque / nominal_stall : 0.0;
    out.kp = stall * s.p_gain * j.p_scale;
    out.kd = stall * (s.d_gain + added);
    out.damping = torque_constant * s.back_emf * j.torque_scale / resistance;
    const double current = std::min(at_most(s.current_limit), j.current_limit);
    out.limit = std::min({stall * std::min(s.duty_limit, j.output_limit), torque_constant * current,
                          at_most(s.torque_limit)});
  } else if (s.actuator != Actuator::passive) {
    const bool position = s.actuator == Actuator::position_pd;
    out.gain = position ? j.torque_scale * supply / j.resistance_scale : j.torque_scale;
    if (position) {
      out.kp = out.gain * s.kp * j.p_scale;
      out.kd = out.gain * (s.kd + j.d_torque);
    }
    out.limit = at_most(s.torque_limit) * j.output_limit;
  }
  return out;
}

}  // namespace sanso::diagnose
