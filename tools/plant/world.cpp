// Keys and ranges of a world file, one function a group; an unknown key is an error that names
// it.
#include "tools/plant/world.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>
#include <system_error>
#include <utility>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "tools/plant/body_data.h"
#include "tools/plant/ground_profile.h"
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
  void integer(const char* key, std::uint64_t& value, long high) const {
    const auto given = table_.integer(key, 0, high);
    if (given) value = static_cast<std::uint64_t>(*given);
  }
  void flag(const char* key, bool& value) const {
    if (const auto given = table_.boolean(key)) value = *given;
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

/// Writes what Section reads.
class Text {
 public:
  explicit Text(std::string& out) : out_(out) {}
  void number(const char* key, double value, double, double) const {
    line(key, files::toml_number(value));
  }
  void integer(const char* key, std::uint64_t value, long) const {
    line(key, std::to_string(value));
  }
  void flag(const char* key, bool value) const { line(key, value ? "true" : "false"); }
  void vector(const char* key, const Vec3& v, double) const {
    line(key, fmt::format("[{}, {}, {}]", files::toml_number(v[0]), files::toml_number(v[1]),
                          files::toml_number(v[2])));
  }
  void text(const char* key, const std::string& value) const {
    line(key, fmt::format("\"{}\"", value));
  }
  template <class Enum>
  void choice(const char* key, Enum value, const std::vector<std::string_view>& names) const {
    line(key, fmt::format("\"{}\"", names[static_cast<std::size_t>(value)]));
  }
  template <class Write>
  void table(const char* key, Write&& write) const {
    out_ += fmt::format("[{}]\n", key);
    write(*this);
  }

 private:
  void line(const char* key, const std::string& value) const {
    out_ += fmt::format("{} = {}\n", key, value);
  }
  std::string& out_;
};

/// One list of the keys for reading (Section) and writing (Text).
void visit_servo(const auto& t, auto& s) {
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
  t.integer("spread_seed", s.spread_seed, std::numeric_limits<long>::max());
  t.number("zero_offset_rad", s.zero_offset_rad, 0, 0.1);
  t.number("gain_spread", s.gain_spread, 0, 0.3);
  t.number("left_gain_scale", s.left_gain_scale, 0.5, 2);
  t.number("p_divisor", s.p_divisor, 32, 1024);
  t.number("loop_period_s", s.loop_period_s, 0.0005, 0.005);
  t.number("command_delay_s", s.command_delay_s, 0, 0.1);
  t.number("sensor_delay_s", s.sensor_delay_s, 0, 0.06);
  t.number("velocity_filter_s", s.velocity_filter_s, 0.0005, 0.1);
  t.number("copper_per_K", s.copper_per_K, 0, 0.01);
}

void visit_ground(const auto& t, auto& g) {
  t.text("profile", g.profile);
  t.number("friction", g.friction, 0.05, 2);
  t.number("tilt_roll_rad", g.tilt_roll_rad, -0.1, 0.1);
  t.number("tilt_pitch_rad", g.tilt_pitch_rad, -0.1, 0.1);
  t.integer("plates", g.plates, 200);
  t.number("plate_height_m", g.plate_height_m, 0, 0.02);
  t.number("contact_time_s", g.contact_time_s, 0.002, 0.05);
}

void visit_wheels(const auto& t, auto& w) {
  t.number("radius_m", w.radius_m, 0.005, 0.02);
  t.number("wheelbase_m", w.wheelbase_m, 0.04, 0.12);
  t.number("track_m", w.track_m, 0.02, 0.08);
  t.number("skate_mass_kg", w.skate_mass_kg, 0.03, 0.2);
  t.number("wheel_mass_kg", w.wheel_mass_kg, 0.002, 0.007);
  t.number("bearing_Nm", w.bearing_Nm, 0, 0.005);
}

void visit_world(const auto& t, auto& world) {
  t.text("name", world.name);
  t.choice("feet", world.feet, {"soles", "wheels"});
  t.number("rest_s", world.rest_s, 0, 86400);
  t.table("body", [&](const auto& b) {
    b.number("torso_extra_mass_kg", world.body.torso_extra_mass_kg, -0.5, 2);
    b.vector("torso_com_offset_m", world.body.torso_com_offset_m, 0.1);
    b.number("leg_mass_scale", world.body.leg_mass_scale, 0.5, 2);
    b.flag("self_collision", world.body.self_collision);
    b.flag("hung", world.body.hung);
  });
  t.table("servo", [&](const auto& s) { visit_servo(s, world.servo); });
  t.table("supply", [&](const auto& s) {
    s.number("voltage_V", world.supply.voltage_V, 9, 16);
    s.number("internal_ohm", world.supply.internal_ohm, 0, 2);
    s.number("charge_Ah", world.supply.charge_Ah, 0, 100);
    s.number("empty_V", world.supply.empty_V, 5, 16);
  });
  t.table("ground", [&](const auto& g) { visit_ground(g, world.ground); });
  t.table("wheels", [&](const auto& w) { visit_wheels(w, world.wheels); });
  t.table("imu", [&](const auto& i) {
    i.number("accel_noise_m_s2", world.imu.accel_noise_m_s2, 0, 5);
    i.number("gyro_noise_rad_s", world.imu.gyro_noise_rad_s, 0, 1);
    i.number("orientation_noise_rad", world.imu.orientation_noise_rad, 0, 0.2);
    i.vector("accel_bias_m_s2", world.imu.accel_bias_m_s2, 3);
    i.vector("gyro_bias_rad_s", world.imu.gyro_bias_rad_s, 0.5);
    i.vector("orientation_bias_rad", world.imu.orientation_bias_rad, 0.2);
    i.number("yaw_drift_rad_s", world.imu.yaw_drift_rad_s, -0.1, 0.1);
    i.number("gravity_filter_s", world.imu.gravity_filter_s, 0, 100);
  });
  t.table("pose", [&](const auto& p) {
    p.number("period_s", world.pose.period_s, 0.001, 1);
    p.number("delay_s", world.pose.delay_s, 0, 0.2);
    p.number("position_noise_m", world.pose.position_noise_m, 0, 0.1);
    p.number("velocity_noise_m_s", world.pose.velocity_noise_m_s, 0, 1);
    p.number("orientation_noise_rad", world.pose.orientation_noise_rad, 0, 0.2);
    p.number("drift_m", world.pose.drift_m, 0, 0.1);
    p.number("dropouts_per_s", world.pose.dropouts_per_s, 0, 10);
    p.number("dropout_s", world.pose.dropout_s, 0.01, 10);
  });
}

bool is_file(const std::string& name) {
  return std::filesystem::exists(name) && !std::filesystem::is_directory(name);
}

/// "17" or "17x1.5" behind the name of a way to draw; the whole, `name`, for messages.
World load_drawn(World (*draw)(std::uint64_t), const std::string& name, std::string_view prefix) {
  const std::string rest = name.substr(prefix.size());
  const std::string digits = rest.substr(0, rest.find('x'));
  const auto refuse = [&] {
    return WorldError(fmt::format(
        "world '{}': expected {}N with a whole number N, or {}NxW with a width W from {} to {}",
        name, prefix, prefix, kNarrowest, kWidest));
  };
  if (digits.empty() || digits.size() > 18 ||
      digits.find_first_not_of("0123456789") != std::string::npos)
    throw refuse();
  World world = draw(std::stoull(digits));
  if (digits == rest) return world;
  const char* const end = rest.data() + rest.size();
  double width = 0.0;
  const auto read = std::from_chars(rest.data() + digits.size() + 1, end, width);
  if (read.ec != std::errc{} || read.ptr != end || !(width >= kNarrowest && width <= kWidest))
    throw refuse();
  return widened(world, width);
}

World load_named(const std::string& name_or_path) {
  for (const auto& [prefix, draw] :
       {std::pair{"seed:", &draw_world}, std::pair{"honest:", &draw_honest_world}})
    if (name_or_path.starts_with(prefix)) return load_drawn(draw, name_or_path, prefix);
  const std::string& built_in = built_in_file(name_or_path + ".toml");
  if (!built_in.empty()) return parse_world(built_in, "worlds/" + name_or_path + ".toml");
  if (!is_file(name_or_path)) {
    throw WorldError(fmt::format(
        "world '{}': expected nominal, lab, hard, back, worst, tired, hung, seed:N, honest:N, "
        "honest:NxWIDTH or the path of a TOML file",
        name_or_path));
  }
  try {
    return parse_world(files::read_text(name_or_path), name_or_path);
  } catch (const files::InputError& error) {
    throw WorldError(error.what());
  }
}

/// "lab+ramp+wheels" into its parts; a file whose name has a plus is one part.
std::vector<std::string> parts_of(const std::string& name) {
  if (is_file(name)) return {name};
  std::vector<std::string> parts;
  std::istringstream text(name);
  for (std::string part; std::getline(text, part, '+');) parts.push_back(part);
  if (parts.empty()) parts.emplace_back();
  return parts;
}

}  // namespace

World parse_world(const std::string& toml_text, const std::string& origin) {
  try {
    World world;
    const Section top(files::TomlTable::parse(toml_text, origin));
    visit_world(top, world);
    top.finish();
    return world;
  } catch (const files::InputError& error) {
    throw WorldError(error.what());
  }
}

std::string to_toml(const World& world) {
  std::string text;
  visit_world(Text(text), world);
  return text;
}

World load_world(const std::string& name_or_path) {
  const std::vector<std::string> parts = parts_of(name_or_path);
  World world = load_named(parts[0]);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (parts[i] == "wheels" || parts[i] == "soles") {
      world.feet = parts[i] == "wheels" ? FeetKind::wheels : FeetKind::soles;
      continue;
    }
    if (parts[i] != "plane") load_profile(parts[i]);  // refuses now what it cannot read
    world.ground.profile = parts[i];
  }
  if (parts.size() > 1) world.name = name_or_path;
  return world;
}

}  // namespace sanso::plant
