// Keys and ranges of a world file, one function a group; an unknown key is an error that names
// it.
#include "tools/plant/world.h"

#include <fmt/format.h>

#include <fstream>
#include <set>
#include <sstream>
#define TOML_HEADER_ONLY 0
#include <toml++/toml.h>

#include "shared/base/toml_grammar.h"
#include "tools/plant/body_data.h"
#include "tools/plant/world_error.h"

namespace sanso::plant {
namespace {

/// Walks one table of a world file: every key must be taken, with its unit's range, or the file is
/// refused.
class TableReader {
 public:
  TableReader(const toml::table& table, std::string path, const std::string& origin)
      : table_(table), path_(std::move(path)), origin_(origin) {}

  void number(const char* key, double& value, double low, double high) {
    const toml::node* node = take(key);
    if (!node) return;
    const auto read = node->value<double>();
    if (!read) refuse(*node, key, "a number");
    if (!(*read >= low && *read <= high))
      refuse(*node, key, fmt::format("a number in [{}, {}]", low, high));
    value = *read;
  }
  void integer(const char* key, std::uint64_t& value) {
    const toml::node* node = take(key);
    if (!node) return;
    const auto read = node->value<std::int64_t>();
    if (!read || *read < 0) refuse(*node, key, "an integer of at least 0");
    value = static_cast<std::uint64_t>(*read);
  }
  void vector(const char* key, Vec3& value, double limit) {
    const toml::node* node = take(key);
    if (!node) return;
    const toml::array* array = node->as_array();
    if (!array || array->size() != 3) refuse(*node, key, "three numbers");
    for (std::size_t i = 0; i < 3; ++i) {
      const auto read = array->get(i)->value<double>();
      if (!read || !(std::abs(*read) <= limit))
        refuse(*node, key, fmt::format("three numbers within +-{}", limit));
      value[i] = *read;
    }
  }
  void text(const char* key, std::string& value) {
    const toml::node* node = take(key);
    if (!node) return;
    const auto read = node->value<std::string>();
    if (!read) refuse(*node, key, "a text");
    value = *read;
  }
  template <class Enum>
  void choice(const char* key, Enum& value,
              std::initializer_list<std::pair<const char*, Enum>> names) {
    const toml::node* node = take(key);
    if (!node) return;
    const auto read = node->value<std::string>();
    std::string expected;
    for (const auto& [name, meaning] : names) {
      if (read && *read == name) {
        value = meaning;
        return;
      }
      expected += fmt::format("{}\"{}\"", expected.empty() ? "" : " or ", name);
    }
    refuse(*node, key, expected);
  }
  template <class Read>
  void table(const char* key, Read&& read) {
    const toml::node* node = take(key);
    if (!node) return;
    const toml::table* inner = node->as_table();
    if (!inner) refuse(*node, key, "a table");
    TableReader reader(*inner, path_ + key + ".", origin_);
    read(reader);
    reader.finish();
  }
  void finish() const {
    for (const auto& [key, node] : table_) {
      const std::string name(key.str());
      if (!taken_.contains(name)) {
        throw WorldError(fmt::format(
            "{}:{}: unknown key '{}{}'; docs/howto/emulator.md lists the keys of a world", origin_,
            node.source().begin.line, path_, name));
      }
    }
  }

 private:
  const toml::node* take(const char* key) {
    taken_.insert(key);
    return table_.get(key);
  }
  [[noreturn]] void refuse(const toml::node& node, const char* key,
                           const std::string& expected) const {
    std::ostringstream value;
    if (node.is_value())
      value << toml::node_view<const toml::node>(node);
    else  // the library's own text of a list casts a negative width to unsigned
      value << (node.is_array() ? "a list" : "a table");
    throw WorldError(fmt::format("{}:{}: {}{} = {}, expected {}", origin_, node.source().begin.line,
                                 path_, key, value.str(), expected));
  }

  const toml::table& table_;
  std::string path_;
  const std::string& origin_;
  std::set<std::string> taken_;
};

void read_servo(TableReader& t, ServoParameters& s) {
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

void read_ground(TableReader& t, GroundParameters& g) {
  t.choice("kind", g.kind,
           {{"plane", GroundKind::plane},
            {"ramp", GroundKind::ramp},
            {"jump_ramp", GroundKind::jump_ramp}});
  t.number("friction", g.friction, 0.05, 2);
  t.number("slope_rad", g.slope_rad, 0, 0.8);
  t.number("start_x_m", g.start_x_m, 0.1, 5);
  t.number("ramp_length_m", g.ramp_length_m, 0.1, 10);
  t.number("lip_height_m", g.lip_height_m, 0, 0.5);
}

void read_world(TableReader& t, World& world) {
  t.text("name", world.name);
  t.table("body", [&](TableReader& b) {
    b.number("torso_extra_mass_kg", world.body.torso_extra_mass_kg, -0.5, 2);
    b.vector("torso_com_offset_m", world.body.torso_com_offset_m, 0.1);
    b.number("leg_mass_scale", world.body.leg_mass_scale, 0.5, 2);
  });
  t.table("servo", [&](TableReader& s) { read_servo(s, world.servo); });
  t.table("supply", [&](TableReader& s) {
    s.number("voltage_V", world.supply.voltage_V, 9, 16);
    s.number("internal_ohm", world.supply.internal_ohm, 0, 2);
  });
  t.table("ground", [&](TableReader& g) { read_ground(g, world.ground); });
  t.choice("feet", world.feet, {{"soles", FeetKind::soles}, {"wheels", FeetKind::wheels}});
  t.table("imu", [&](TableReader& i) {
    i.number("accel_noise_m_s2", world.imu.accel_noise_m_s2, 0, 5);
    i.number("gyro_noise_rad_s", world.imu.gyro_noise_rad_s, 0, 1);
    i.number("orientation_noise_rad", world.imu.orientation_noise_rad, 0, 0.2);
    i.vector("accel_bias_m_s2", world.imu.accel_bias_m_s2, 3);
    i.vector("gyro_bias_rad_s", world.imu.gyro_bias_rad_s, 0.5);
    i.vector("orientation_bias_rad", world.imu.orientation_bias_rad, 0.2);
  });
  t.table("pose", [&](TableReader& p) {
    p.number("period_s", world.pose.period_s, 0.001, 1);
    p.number("delay_s", world.pose.delay_s, 0, 0.2);
    p.number("position_noise_m", world.pose.position_noise_m, 0, 0.1);
    p.number("velocity_noise_m_s", world.pose.velocity_noise_m_s, 0, 1);
    p.number("orientation_noise_rad", world.pose.orientation_noise_rad, 0, 0.2);
  });
}

}  // namespace

World parse_world(const std::string& toml_text, const std::string& origin) {
  if (const auto defect = first_toml_defect(toml_text))
    throw WorldError(origin + ":" + describe(*defect));
  toml::table table;
  try {
    table = toml::parse(toml_text, origin);
  } catch (const toml::parse_error& error) {
    throw WorldError(
        fmt::format("{}:{}: {}", origin, error.source().begin.line, error.description()));
  }
  World world;
  TableReader reader(table, "", origin);
  read_world(reader, world);
  reader.finish();
  return world;
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
    throw WorldError(
        fmt::format("world '{}': expected nominal, lab, hard, seed:N or the path of a TOML file",
                    name_or_path));
  }
  std::ostringstream text;
  text << file.rdbuf();
  return parse_world(text.str(), name_or_path);
}

}  // namespace sanso::plant
