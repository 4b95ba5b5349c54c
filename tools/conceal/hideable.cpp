// One function a family, one entry an effect: how to hide it at a joint with a strength, and
// what the answer will say.
#include "tools/conceal/hideable.h"

#include <algorithm>
#include <cmath>

#include "tools/plant/world_error.h"

namespace sanso::conceal {

using plant::operator+;

namespace {

using Scope = Hideable::Scope;
using Parameters = std::map<std::string, double>;

JointTruth& joint(WorldTruth& world, int at) { return world.joints[static_cast<std::size_t>(at)]; }
LinkSpec& link(WorldTruth& world, int at) {
  return world.robot.links[static_cast<std::size_t>(at)];
}
double sign(Random& random) { return random.chance(0.5) ? 1.0 : -1.0; }

/// An effect of one joint: `change` sets the joint and returns the parameters by name.
Hideable on_joint(std::string id, double typical, double largest,
                  std::function<Parameters(JointTruth&, double size, Random&)> change,
                  std::vector<std::string> twins = {}) {
  const std::string name = id;
  return {
      std::move(id),
      Scope::joint,
      typical,
      largest,
      true,
      [name, change](WorldTruth& world, int at, double size, Random& random) {
        return HiddenEffect{name, {link(world, at).joint}, change(joint(world, at), size, random)};
      },
      std::move(twins)};
}

Hideable on_link(std::string id, double typical, double largest,
                 std::function<Parameters(WorldTruth&, int at, double size, Random&)> change) {
  const std::string name = id;
  return {std::move(id),
          Scope::link,
          typical,
          largest,
          true,
          [name, change](WorldTruth& world, int at, double size, Random& random) {
            return HiddenEffect{name, {link(world, at).link}, change(world, at, size, random)};
          },
          {}};
}

Hideable on_robot(std::string id, double typical, double largest,
                  std::function<Parameters(WorldTruth&, double size, Random&)> change,
                  std::vector<std::string> twins = {}) {
  const std::string name = id;
  return {std::move(id),
          Scope::robot,
          typical,
          largest,
          true,
          [name, change](WorldTruth& world, int, double size, Random& random) {
            return HiddenEffect{name, {}, change(world, size, random)};
          },
          std::move(twins)};
}

Hideable outside(std::string id, double typical, double largest,
                 std::function<void(WorldTruth&, int at, double size, Random&)> change) {
  const std::string name = id;
  return {std::move(id),
          Scope::joint,
          typical,
          largest,
          false,
          [name, change](WorldTruth& world, int at, double size, Random& random) {
            change(world, at, size, random);
            return HiddenEffect{name, {link(world, at).joint}, {{"size", size}}};
          },
          {}};
}

std::vector<Hideable> friction_effects() {
  return {
      on_joint("viscous_friction", 0.2, 2.0,
               [](JointTruth& j, double s, Random&) {
                 j.viscous += s;
                 return Parameters{{"viscous", s}};
               },
               {"servo_d_gain", "torque_constant"}),
      on_joint("coulomb_friction", 0.08, 0.5,
               [](JointTruth& j, double s, Random&) {
                 j.coulomb += s;
                 return Parameters{{"coulomb", s}};
               }),
      on_joint("stribeck_friction", 0.1, 0.6,
               [](JointTruth& j, double s, Random& r) {
                 j.stribeck = s;
                 j.stribeck_speed = r.uniform(0.1, 0.5);
                 return Parameters{{"stribeck", s}, {"speed", j.stribeck_speed}};
               }),
      on_joint("load_friction", 0.08, 0.4,
               [](JointTruth& j, double s, Random&) {
                 j.load = s;
                 return Parameters{{"load", s}};
               }),
      on_joint("directional_load_friction", 0.15, 0.5,
               [](JointTruth& j, double s, Random& r) {
                 j.drive = s;
                 j.backdrive = s * r.uniform(0.1, 0.5);
                 return Parameters{{"drive", j.drive}, {"backdrive", j.backdrive}};
               }),
      on_joint("quadratic_load_friction", 0.08, 0.2,
               [](JointTruth& j, double s, Random&) {
                 j.quadratic = s;
                 return Parameters{{"quadratic", s}};
               }),
      on_joint("asymmetric_friction", 0.06, 0.3,
               [](JointTruth& j, double s, Random& r) {
                 s *= sign(r);
                 // friction stays positive both ways
                 j.coulomb += std::max(0.0, std::abs(s) - j.coulomb);
                 j.coulomb_difference = s;
                 return Parameters{{"coulomb_difference", s}};
               }),
      on_joint("presliding_friction", 0.1, 0.5,
               [](JointTruth& j, double s, Random& r) {
                 const double compliance = r.uniform(0.03, 0.15);  // rad/(N m)
                 j.coulomb += s;
                 j.bristle_stiffness = 1 / compliance;
                 j.bristle_damping = 0.1;
                 return Parameters{{"coulomb", s}, {"compliance", compliance}};
               }),
      on_joint("position_friction", 0.06, 0.4,
               [](JointTruth& j, double s, Random& r) {
                 const double phase = r.uniform(0, 2 * plant::kPi);
                 j.ripple_order = 1 + static_cast<double>(r.bits() % 8);
                 j.ripple_sine = s * std::sin(phase);
                 j.ripple_cosine = s * std::cos(phase);
                 j.coulomb += std::max(0.0, s - j.coulomb);
                 return Parameters{{"sine", j.ripple_sine},
                                   {"cosine", j.ripple_cosine},
                                   {"order", j.ripple_order}};
               }),
      on_joint("dwell_stiction", 0.1, 0.5,
               [](JointTruth& j, double s, Random& r) {
                 j.static_friction = s;
                 j.dwell_rate = r.uniform(0.3, 1.0);
                 return Parameters{{"static", s}, {"dwell_rate", j.dwell_rate}};
               }),
  };
}

std::vector<Hideable> gear_effects() {
  return {
      on_joint("backlash", 0.02, 0.06,
               [](JointTruth& j, double s, Random&) {
                 j.backlash = s;
                 return Parameters{{"width", s}};
               }),
      on_joint("joint_compliance", 0.02, 0.1,
               [](JointTruth& j, double s, Random& r) {
                 j.compliance = s;
                 j.compliance_damping = r.uniform(0.05, 0.4);
                 return Parameters{{"compliance", s}, {"damping", j.compliance_damping}};
               }),
      on_joint("cogging", 0.05, 0.2,
               [](JointTruth& j, double s, Random& r) {
                 const double phase = r.uniform(0, 2 * plant::kPi);
                 j.cogging_order = 4 + static_cast<double>(r.bits() % 20);
                 j.cogging_sine = s * std::sin(phase);
                 j.cogging_cosine = s * std::cos(phase);
                 return Parameters{{"sine", j.cogging_sine},
                                   {"cosine", j.cogging_cosine},
                                   {"order", j.cogging_order}};
               }),
      on_joint("rotor_inertia", 0.02, 0.1,
               [](JointTruth& j, double s, Random&) {
                 j.armature += s;
                 return Parameters{{"armature", s}};
               }),
      on_joint("gear_efficiency", 0.15, 0.6,
               [](JointTruth& j, double s, Random&) {
                 j.efficiency = 1 - s;
                 return Parameters{{"efficiency", j.efficiency}};
               }),
      on_joint("cable_spring", 0.3, 2.0,
               [](JointTruth& j, double s, Random& r) {
                 j.spring = s;
                 j.spring_torque = s * r.uniform(-0.3, 0.3);
                 return Parameters{{"stiffness", s}, {"torque", j.spring_torque}};
               }),
      on_joint("joint_stop", 10, 500,
               [](JointTruth& j, double s, Random& r) {
                 j.stop_stiffness = s;
                 j.stop_side = sign(r);
                 j.stop_position = j.stop_side * r.uniform(0.2, 0.3);
                 return Parameters{
                     {"stiffness", s}, {"position", j.stop_position}, {"side", j.stop_side}};
               }),
      on_joint("air_drag", 0.04, 0.2,
               [](JointTruth& j, double s, Random&) {
                 j.air_drag = s;
                 return Parameters{{"drag", s}};
               }),
  };
}

std::vector<Hideable> mass_effects() {
  return {
      on_link("link_mass", 0.15, 0.5,
              [](WorldTruth& w, int at, double s, Random& r) {
                s *= sign(r);
                LinkSpec& l = link(w, at);
                l.mass *= 1 + s;
                for (double& i : l.inertia) i *= 1 + s;
                return Parameters{{"share", s}};
              }),
      on_link("link_com", 0.01, 0.03,
              [](WorldTruth& w, int at, double s, Random& r) {
                const double angle = r.uniform(0, 2 * plant::kPi);
                const Vec3 shift{s * std::cos(angle), 0, s * std::sin(angle)};
                link(w, at).com = link(w, at).com + shift;
                return Parameters{{"x", shift[0]}, {"y", 0}, {"z", shift[2]}};
              }),
      on_link("link_inertia", 0.3, 0.6,
              [](WorldTruth& w, int at, double s, Random&) {
                add_axis_inertia(link(w, at), s);
                return Parameters{{"share", s}};
              }),
      on_link("payload", 0.1, 0.8,
              [](WorldTruth& w, int at, double s, Random& r) {
                w.payload = {at, s, r.uniform(5, 12)};
                const Vec3& p = link(w, at).payload_at;
                return Parameters{
                    {"mass", s}, {"x", p[0]}, {"y", p[1]}, {"z", p[2]}, {"from", w.payload.from_s}};
              }),
      on_link("external_push", 3, 50,
              [](WorldTruth& w, int at, double s, Random& r) {
                const double from = r.uniform(3, 15), duration = r.uniform(0.1, 0.4);
                const Vec3 force{s * sign(r), 0, 0};
                w.push = {at, force, from, from + duration};
                return Parameters{
                    {"x", force[0]}, {"y", 0}, {"z", 0}, {"from", from}, {"duration", duration}};
              }),
      on_link("tether", 1, 15,
              [](WorldTruth& w, int at, double s, Random& r) {
                const double angle = r.uniform(0, 2 * plant::kPi);
                w.tether = {at, {s * std::cos(angle), 0, s * std::sin(angle)}, -1e9, 1e9};
                return Parameters{{"x", w.tether.force[0]}, {"y", 0}, {"z", w.tether.force[2]}};
              }),
  };
}

std::vector<Hideable> electrical_effects() {
  return {
      on_joint("servo_p_gain", 0.2, 0.6,
               [](JointTruth& j, double s, Random& r) {
                 const double gain = r.chance(0.6) ? 1 - s : 1 + s;
                 j.p_gain *= gain;
                 return Parameters{{"gain", gain}};
               },
               {"torque_constant", "battery_drift", "link_mass"}),
      on_joint("servo_d_gain", 0.3, 2.0,
               [](JointTruth& j, double s, Random&) {
                 j.d_gain = s * j.resistance / (j.torque_constant * j.voltage);
                 return Parameters{{"damping", s}};
               },
               {"viscous_friction"}),
      on_joint("servo_i_gain", 1.0, 15,
               [](JointTruth& j, double s, Random&) {
                 j.i_rate = s;
                 return Parameters{{"integral", s}};
               }),
      on_joint("torque_constant", 0.2, 0.4,
               [](JointTruth& j, double s, Random& r) {
                 const double scale = 1 + s * sign(r);
                 j.torque_constant *= scale;
                 j.back_emf *= scale;
                 return Parameters{{"torque", scale}};
               },
               {"servo_p_gain", "battery_drift", "link_mass"}),
      on_joint("voltage_limit", 0.3, 0.85,
               [](JointTruth& j, double s, Random&) {
                 j.duty_limit = 1 - s;
                 return Parameters{{"limit", 1 - s}};
               }),
      on_joint("current_limit", 0.5, 0.95,
               [](JointTruth& j, double s, Random&) {
                 j.current_limit = 1.5 * (1 - s);
                 return Parameters{{"current", j.current_limit}};
               }),
      on_robot("supply_sag", 0.5, 3.0,
               [](WorldTruth& w, double s, Random&) {
                 w.supply_resistance = s;
                 return Parameters{{"resistance", s}};
               }),
      on_robot("battery_drift", 0.08, 0.2,
               [](WorldTruth& w, double s, Random& r) {
                 w.supply_level = -s;
                 w.supply_slope_per_min = -r.uniform(0.0, 0.5) * s;
                 return Parameters{{"level", -s}, {"slope", w.supply_slope_per_min}};
               },
               {"servo_p_gain", "torque_constant"}),
      on_joint("servo_deadband", 0.01, 0.03,
               [](JointTruth& j, double s, Random&) {
                 j.dead_zone = s;
                 return Parameters{{"zone", s}};
               }),
      on_joint("servo_profile", 0.5, 0.95,
               [](JointTruth& j, double s, Random&) {
                 j.profile_speed = 4.0 * (1 - s);
                 return Parameters{{"speed", j.profile_speed}};
               }),
  };
}

std::vector<Hideable> clock_and_sensor_effects() {
  return {
      on_joint("command_delay", 0.015, 0.06,
               [](JointTruth& j, double s, Random&) {
                 j.command_delay_s += s;
                 return Parameters{{"delay", s}};
               },
               {"sensor_delay"}),
      on_joint("sensor_delay", 0.015, 0.06,
               [](JointTruth& j, double s, Random&) {
                 j.sensor_delay_s += s;
                 return Parameters{{"delay", s}};
               },
               {"command_delay"}),
      on_joint("sample_hold", 2, 4,
               [](JointTruth& j, double s, Random&) {
                 j.hold_cycles = std::clamp(static_cast<int>(std::lround(s)), 2, 4);
                 return Parameters{{"cycles", static_cast<double>(j.hold_cycles)}};
               }),
      on_joint("timing_jitter", 0.003, 0.008,
               [](JointTruth& j, double s, Random&) {
                 j.jitter_s = s;
                 return Parameters{{"jitter", s}};
               }),
      on_joint("packet_loss", 0.1, 0.3,
               [](JointTruth& j, double s, Random&) {
                 j.loss = s;
                 return Parameters{{"loss", s}};
               }),
      on_joint("encoder_offset", 0.03, 0.1,
               [](JointTruth& j, double s, Random& r) {
                 j.offset = s * sign(r);
                 return Parameters{{"offset", j.offset}};
               }),
      on_joint("encoder_nonlinearity", 0.01, 0.03,
               [](JointTruth& j, double s, Random& r) {
                 const double phase = r.uniform(0, 2 * plant::kPi);
                 j.encoder_sine = s * std::sin(phase);
                 j.encoder_cosine = s * std::cos(phase);
                 return Parameters{{"sine", j.encoder_sine}, {"cosine", j.encoder_cosine}};
               }),
      on_joint("velocity_filter", 0.015, 0.05,
               [](JointTruth& j, double s, Random&) {
                 j.velocity_filter_s = s;
                 return Parameters{{"time", s}};
               }),
  };
}

std::vector<Hideable> outside_effects() {
  return {
      outside("cubic_spring", 1.0, 10,
              [](WorldTruth& w, int at, double s, Random&) { joint(w, at).cubic_spring = s; }),
      outside("angle_damping", 0.5, 4,
              [](WorldTruth& w, int at, double s, Random&) { joint(w, at).angle_damping = s; }),
      outside("gain_softening", 1.0, 12,
              [](WorldTruth& w, int at, double s, Random&) { joint(w, at).gain_softening = s; }),
      outside("creep_spring", 0.5, 4,
              [](WorldTruth& w, int at, double s, Random& r) {
                joint(w, at).creep_spring = s;
                joint(w, at).creep_time_s = r.uniform(0.3, 1.5);
              }),
      outside("joint_coupling", 0.1, 1.0,
              [](WorldTruth& w, int at, double s, Random& r) {
                const int n = w.robot.size();
                if (n < 2) {
                  joint(w, at).cubic_spring = 4 * s;  // one joint has nothing to be coupled with
                  return;
                }
                w.coupling = {
                    (at + 1 + static_cast<int>(r.bits() % static_cast<std::uint64_t>(n - 1))) % n,
                    at, s};
              }),
  };
}

}  // namespace

const std::vector<Hideable>& hideables() {
  static const std::vector<Hideable> all = [] {
    std::vector<Hideable> out;
    for (auto make : {friction_effects, gear_effects, mass_effects, electrical_effects,
                      clock_and_sensor_effects, outside_effects}) {
      for (Hideable& h : make()) out.push_back(std::move(h));
    }
    return out;
  }();
  return all;
}

const Hideable& hideable(const std::string& id) {
  for (const Hideable& h : hideables()) {
    if (h.id == id) return h;
  }
  throw plant::WorldError("no effect '" + id + "' can be hidden; docs/howto/conceal.md lists them");
}

}  // namespace sanso::conceal
