// Keys and ranges of a world file, one function a group; an unknown key is an error that names
// it.
#include "tools/plant/world.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "tools/plant/body_data.h"
#include "tools/plant/world_error.h"

namespace sanso::plant {
namespace {

/// One table of a world file: what is given replaces the default, what is not known is refused.
class Section {
 public:
  explicit Section(files::TomlTable table) : table_(std::move(table)) {}
  void number(const char* key, double& value, double low, double high) const {
    files::TomlTable::into(value, table_.number(key, low, high));
  }
  void integer(const char* key, std::uint64_t& value) const {
    const auto given = table_.integer(key, 0, std::numeric_limits<long>::max());
    if (given) value = static_cast<std::uint64_t>(*given);
  }
  void vector(const char* key, Vec3& value, double limit) const {
    const auto given = table_.numbers(key, 3);
    if (!given) return;
    for (std::size_t i = 0; i < 3; ++i) {
      if (std::abs((*given)[i]) > limit)
        table_.fail(key, "out of range", files::toml_number((*given)[i]),
                    fmt::format("three numbers within +-{}", limit));
      value[i] = (*given)[i];
    }
  }
  void text(const char* key, std::string& value) const {
    files::TomlTable::into(value, table_.string(key));
  }
  /// The names of an enum, in its order.
  template <class Enum>
  void choice(const char* key, Enum& value, const std::vector<std::string_view>& names) const {
    if (const auto given = table_.choice(key, names)) value = static_cast<Enum>(*given);
  }
  template <class Read>
  void table(const char* key, Read&& read) const {
    const auto inner = table_.table(key);
    if (!inner) return;
    const Section section(*inner);
    read(section);
    section.finish();
  }
  void finish() const {
    table_.finish("one of the keys of a world, listed in docs/howto/emulator.md");
  }

 private:
  files::TomlTable table_;
};

void read_servo(const Section& t, ServoParameters& s) {
  t.number("resistance_ohm", s.resistance_ohm, 0.5, 50);
  t.number("torque_constant_Nm_A", s.torque_constant_Nm_A, 0.1, 10);
  t.number("back_emf_V_s", s.back_emf_V_s, 0.1, 10);
  t.number("motor_inertia_kgm2", s.motor_inertia_kgm2, 0.002, 0.2);
  t.number("output_inertia_kgm2", s.output_inertia_kgm2, 0.001, 0.05);
  t.number("gear_stiffness_Nm_rad", s.gear_stiffness_Nm_rad, 50, 3000);
  t.number("gear_damping_Nms_rad", s.gear_damping_Nms_rad, 0.05, 2);
  t.number("backlash_rad", s.backlash_rad, 0, 0.1);
  t.number("coulomb_Nm", s.coulomb_Nm, 0, 1);
  t.number("stribeck_extra_Nm", s.stribeck_extra_Nm, 0, 1);
  t.number("stribeck_velocity_rad_s", s.stribeck_velocity_rad_s, 0.001, 1);
  t.number("load_friction", s.load_friction, 0, 0.6);
  t.number("viscous_Nms_rad", s.viscous_Nms_rad, 0, 2);
  t.number("spread", s.spread, 0, 0.3);
  t.integer("spread_seed", s.spread_seed);
  t.number("p_divisor", s.p_divisor, 32, 1024);
  t.number("loop_period_s", s.loop_period_s, 0.0005, 0.005);
  t.number("command_delay_s", s.command_delay_s, 0, 0.1);
  t.number("sensor_delay_s", s.sensor_delay_s, 0, 0.06);
  t.number("velocity_filter_s", s.velocity_filter_s, 0.0005, 0.1);
}

void read_ground(const Section& t, GroundParameters& g) {
  t.choice("kind", g.kind, {"plane", "ramp", "jump_ramp"});
  t.number("friction", g.friction, 0.05, 2);
  t.number("slope_rad", g.slope_rad, 0, 0.8);
  t.number("start_x_m", g.start_x_m, 0.1, 5);
  t.number("ramp_length_m", g.ramp_length_m, 0.1, 10);
  t.number("lip_height_m", g.lip_height_m, 0, 0.5);
}

void read_world(const Section& t, World& world) {
  t.text("name", world.name);
  t.table("body", [&](const Section& b) {
    b.number("torso_extra_mass_kg", world.body.torso_extra_mass_kg, -0.5, 2);
    b.vector("torso_com_offset_m", world.body.torso_com_offset_m, 0.1);
    b.number("leg_mass_scale", world.body.leg_mass_scale, 0.5, 2);
  });
  t.table("servo", [&](const Section& s) { read_servo(s, world.servo); });
  t.table("supply", [&](const Section& s) {
    s.number("voltage_V", world.supply.voltage_V, 9, 16);
    s.number("internal_ohm", world.supply.internal_ohm, 0, 2);
  });
  t.table("ground", [&](const Section& g) { read_ground(g, world.ground); });
  t.choice("feet", world.feet, {"soles", "wheels"});
  t.table("imu", [&](const Section& i) {
    i.number("accel_noise_m_s2", world.imu.accel_noise_m_s2, 0, 5);
    i.number("gyro_noise_rad_s", world.imu.gyro_noise_rad_s, 0, 1);
    i.number("orientation_noise_rad", world.imu.orientation_noise_rad, 0, 0.2);
    i.vector("accel_bias_m_s2", world.imu.accel_bias_m_s2, 3);
    i.vector("gyro_bias_rad_s", world.imu.gyro_bias_rad_s, 0.5);
    i.vector("orientation_bias_rad", world.imu.orientation_bias_rad, 0.2);
  });
  t.table("pose", [&](const Section& p) {
    p.number("period_s", world.pose.period_s, 0.001, 1);
    p.number("delay_s", world.pose.delay_s, 0, 0.2);
    p.number("position_noise_m", world.pose.position_noise_m, 0, 0.1);
    p.number("velocity_noise_m_s", world.pose.velocity_noise_m_s, 0, 1);
    p.number("orientation_noise_rad", world.pose.orientation_noise_rad, 0, 0.2);
  });
}

}  // namespace

World parse_world(const std::string& toml_text, const std::string& origin) {
  try {
    World world;
    const Section top(files::TomlTable::parse(toml_text, origin));
    read_world(top, world);
    top.finish();
    return world;
  } catch (const files::InputError& error) {
    throw WorldError(error.what());
  }
}

World load_world(const std::string& name_or_path) {
  if (name_or_path.starts_with("seed:")) {
    const std::string digits = name_or_path.substr(5);
    if (digits.empty() || digits.size() > 18 ||
        digits.find_first_not_of("0123456789") != std::string::npos) {
      throw WorldError(
          fmt::format("world '{}': expected seed:N with a whole number N", name_or_path));
    }
    return draw_world(std::stoull(digits));
  }
  const std::string& built_in = built_in_file(name_or_path + ".toml");
  if (!built_in.empty()) return parse_world(built_in, "worlds/" + name_or_path + ".toml");
  std::ifstream file(name_or_path);
  if (!file) {
    throw WorldError(fmt::format(
        "world '{}': expected nominal, lab, hard, back, worst, seed:N or the path of a TOML file",
        name_or_path));
  }
  std::ostringstream text;
  text << file.rdbuf();
  return parse_world(text.str(), name_or_path);
}

}  // namespace sanso::plant
