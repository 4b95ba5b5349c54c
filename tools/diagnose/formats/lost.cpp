// One table of everything that a joint of the simulator can have, with the formats that hold it. A
// new field of JointParams without a row here would be lost without a word: the test of this room
// walks the library.
#include <fmt/format.h>

#include <cmath>

#include "tools/diagnose/formats/parts.h"

namespace sanso::diagnose {
namespace {

using P = JointParams;

bool drives(const P& j) { return j.nominal.actuator != Actuator::passive; }
bool follows_goal(const P& j) {
  return j.nominal.actuator == Actuator::dc_servo || j.nominal.actuator == Actuator::position_pd;
}
bool integrates(const P& j) {
  return j.integral_rate != 0.0 ||
         (j.nominal.actuator == Actuator::dc_servo && j.nominal.i_gain != 0.0);
}
bool servo_limits(const P& j) {
  const JointSettings& s = j.nominal;
  return s.actuator == Actuator::dc_servo &&
         (s.torque_limit > 0.0 || s.current_limit > 0.0 || j.current_limit < kNone);
}

struct Row {
  unsigned held;  // Format bits
  const char* words;
  bool (*there)(const P&);
};

const Row kRows[] = {
    {kMjcf, "actuator: gains, motor, limits", [](const P& j) { return drives(j); }},
    {kMjcf, "rotor inertia", [](const P& j) { return j.nominal.armature + j.armature != 0.0; }},
    {kMjcf | kUrdf | kSdf, "viscous friction", [](const P& j) { return j.viscous != 0.0; }},
    {kMjcf | kUrdf | kSdf, "Coulomb friction", [](const P& j) { return j.coulomb != 0.0; }},
    {kMjcf | kSdf, "spring", [](const P& j) { return j.spring != 0.0; }},
    {0, "constant torque at the joint",
     [](const P& j) { return j.spring_torque != 0.0 && j.spring == 0.0; }},
    {0, "command delay",
     [](const P& j) { return j.nominal.command_delay_s + j.command_delay > 0.0; }},
    {0, "sensor delay", [](const P& j) { return j.nominal.sensor_delay_s + j.sensor_delay > 0.0; }},
    {0, "commands taken at a lower rate", [](const P& j) { return j.hold_cycles > 1; }},
    {0, "lost commands", [](const P& j) { return j.loss > 0.0; }},
    {0, "jitter of the readings", [](const P& j) { return j.jitter > 0.0; }},
    {0, "encoder steps and noise",
     [](const P& j) { return j.nominal.position_quantum > 0.0 || j.nominal.position_noise > 0.0; }},
    {0, "filter of the servo's output or of its D gain",
     [](const P& j) { return j.output_filter > 0.0; }},
    {0, "integral gain", [](const P& j) { return follows_goal(j) && integrates(j); }},
    {0, "D gain of the servo on the error",
     [](const P& j) { return j.d_torque != 0.0 && j.d_on_error != 0.0; }},
    {0, "feed-forward of the servo", [](const P& j) { return j.feed_forward != 0.0; }},
    {0, "profile inside the servo",
     [](const P& j) { return j.profile_speed < kNone || j.profile_acceleration < kNone; }},
    {0, "dead zone of the servo", [](const P& j) { return j.dead_zone > 0.0; }},
    {0, "torque-speed line", [](const P& j) { return j.no_load_speed < kNone; }},
    {0, "torque lost when hot", [](const P& j) { return j.derating != 0.0; }},
    {0, "limits of current and torque beyond what the servo commands (back-EMF while braking)",
     [](const P& j) { return servo_limits(j); }},
    {0, "Stribeck friction", [](const P& j) { return j.stribeck != 0.0; }},
    {0, "load-dependent friction",
     [](const P& j) {
       return j.load_friction != 0.0 || j.drive_friction != 0.0 || j.backdrive_friction != 0.0 ||
              j.quadratic_load_friction != 0.0;
     }},
    {0, "gear efficiency", [](const P& j) { return j.efficiency != 1.0; }},
    {0, "friction that differs forwards and backwards",
     [](const P& j) { return j.coulomb_difference != 0.0 || j.viscous_difference != 0.0; }},
    {0, "creeping of dry friction", [](const P& j) { return j.creep_speed != 0.0; }},
    {0, "presliding of the friction",
     [](const P& j) { return j.presliding_compliance != 0.0 || j.presliding_damping != 0.0; }},
    {0, "Maxwell slip friction", [](const P& j) { return j.slip_torque != 0.0; }},
    {0, "friction that depends on the angle", [](const P& j) { return !j.friction_ripple.zero(); }},
    {0, "friction that falls with temperature",
     [](const P& j) { return j.friction_temperature != 0.0; }},
    {0, "stiction that grows at rest",
     [](const P& j) { return j.static_friction != 0.0 || j.dwell_rate != 0.0; }},
    {0, "backlash", [](const P& j) { return j.backlash != 0.0; }},
    {0, "compliance between motor and link", [](const P& j) { return j.compliance != 0.0; }},
    {0, "gear ripple", [](const P& j) { return !j.gear_error.zero(); }},
    {0, "cogging", [](const P& j) { return !j.cogging.zero(); }},
    {0, "aerodynamic drag", [](const P& j) { return j.air_drag != 0.0; }},
    {0, "joint stop", [](const P& j) { return j.stop_stiffness != 0.0; }},
    {0, "encoder offset, scale or ripple",
     [](const P& j) {
       return j.encoder_offset != 0.0 || j.encoder_scale != 0.0 || !j.encoder_error.zero() ||
              j.record_offset != 0.0;
     }},
    {0, "filter of the velocity channel", [](const P& j) { return j.velocity_filter != 0.0; }},
};

std::string joints_with(const SimParams& params, const Row& row) {
  std::string names;
  std::size_t count = 0;
  for (std::size_t j = 0; j < params.joints.size(); ++j)
    if (row.there(params.joints[j])) {
      names += (count++ > 0 ? ", " : "") + params.tree.joints[j].name;
    }
  return count == params.size() && count > 1 ? "every joint" : names;
}

}  // namespace

std::vector<std::string> lost_in(Format format, const SimParams& params) {
  std::vector<std::string> out;
  for (const Row& row : kRows) {
    if ((row.held & format) != 0) continue;
    const std::string joints = joints_with(params, row);
    if (!joints.empty()) out.push_back(fmt::format("{}: {}", row.words, joints));
  }
  constexpr Vec3 kUsual{0, 0, -9.81};
  if (format != kMjcf && params.gravity != kUsual)
    out.push_back(fmt::format("gravity ({}), which belongs to the world", numbers(params.gravity)));
  if (params.supply_level != 0.0 && format != kMjcf) out.emplace_back("level of the supply");
  if (params.supply_slope != 0.0) out.emplace_back("drift of the supply");
  if (params.supply_resistance != 0.0) out.emplace_back("sag of the supply under current");
  if (!params.forces.empty()) out.emplace_back("forces from outside (push, tether)");
  if (!params.late_payloads.empty()) out.emplace_back("a payload that is put on later");
  return out;
}

}  // namespace sanso::diagnose
