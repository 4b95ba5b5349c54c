// Settings first, then the URDF, then the joints by the names that it gives.
#include "tools/diagnose/model_folder/model_folder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <sstream>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "tools/diagnose/model_folder/body_tree.h"
#include "tools/diagnose/model_folder/model_text.h"

namespace sanso::diagnose {
namespace {

using files::InputError;
using files::TomlTable;
constexpr GroundKind kGroundKinds[] = {GroundKind::plane, GroundKind::ramp, GroundKind::jump_ramp,
                                       GroundKind::heights};
constexpr double kInf = std::numeric_limits<double>::infinity();

void read_joint(const TomlTable& table, JointSettings& settings) {
  std::vector<std::string_view> known{"actuator"};
  JointSettings::visit(settings, [&](std::string_view key, double& value, std::string_view,
                                     double low, double high) {
    known.push_back(key);
    if (const auto read = table.number(key, low, high)) value = *read;
  });
  table.allow_only(known);
  if (const auto name = table.string("actuator")) {
    const auto actuator = recording::actuator_from(*name);
    if (!actuator)
      table.fail("actuator", "unknown actuator", *name, "torque, position_pd, dc_servo or passive");
    settings.actuator = *actuator;
  }
}

void read_robot(const TomlTable& table, ModelFolder& model) {
  table.allow_only({"urdf", "base", "gravity"});
  model.urdf_file = table.string("urdf").value_or(model.urdf_file);
  const std::string base = table.string("base").value_or("fixed");
  if (base != "fixed" && base != "floating")
    table.fail("base", "unknown base", base, "fixed or floating");
  model.floating = base == "floating";
  if (table.has("base")) model.base_line = table.line_of("base");
  if (const auto g = table.numbers("gravity", 3)) model.gravity = {(*g)[0], (*g)[1], (*g)[2]};
}

void read_ground(const TomlTable& table, ModelFolder& model) {
  // the last four are read by whole_body.cpp
  table.allow_only({"kind", "friction", "stiffness", "damping", "restitution", "height"});
  if (const auto said = table.string("kind")) {
    const auto kind = std::find_if(std::begin(kGroundKinds), std::end(kGroundKinds),
                                   [&](GroundKind k) { return *said == to_string(k); });
    if (kind == std::end(kGroundKinds))
      table.fail("kind", "unknown ground", *said, "plane, ramp, jump_ramp or heights");
    model.ground_kind = *kind;
  }
  model.ground_friction = table.number("friction", 0.0, 10.0).value_or(model.ground_friction);
}

EffectEntry read_effect(const TomlTable& table) {
  EffectEntry effect;
  effect.line = table.line();
  const auto id = table.string("id");
  if (!id) table.fail("id", "missing key", "", "the id of an effect of the library");
  effect.id = *id;
  effect.where = table.strings("where").value_or(std::vector<std::string>{});
  for (const std::string& key : table.keys()) {
    if (key != "id" && key != "where") effect.parameters[key] = *table.number(key, -kInf, kInf);
  }
  return effect;
}

/// Everything of model.toml but the joints, whose names are only known when the URDF has been read.
void read_settings(const TomlTable& top, ModelFolder& model) {
  top.allow_only({"format", "robot", "control", "joint_default", "joint", "ground", "effect", "imu",
                  "contact"});
  const auto format = top.integer("format");
  if (!format) top.fail("format", "missing key", "", "format = 1 in the first line");
  if (*format != 1) top.fail("format", "unknown format", std::to_string(*format), "1");
  if (const auto table = top.table("robot")) read_robot(*table, model);
  if (const auto table = top.table("control")) {
    table->allow_only({"period_s"});
    model.period_s = table->number("period_s", 1e-5, 10.0).value_or(model.period_s);
  }
  if (const auto table = top.table("ground")) read_ground(*table, model);
  if (const auto table = top.table("joint_default")) read_joint(*table, model.joint_default);
  for (const TomlTable& table : top.tables("effect")) model.effects.push_back(read_effect(table));
}

/// Of a base that floats the whole tree: what has no joint is one body.
RobotTree read_tree(const ModelFolder& model, const std::string& file) {
  return model.floating ? body_tree_from_urdf(model.urdf, file, 0).tree
                        : tree_from_urdf(model.urdf, file);
}

std::string joint_names(const RobotTree& tree) {
  std::string names;
  for (const TreeJoint& joint : tree.joints) names += (names.empty() ? "" : ", ") + joint.name;
  return names;
}

void read_joints(const TomlTable& top, ModelFolder& model) {
  model.joints.assign(model.tree.joints.size(), model.joint_default);
  const auto joints = top.table("joint");
  if (!joints) return;
  for (const std::string& name : joints->keys()) {
    const int index = model.tree.index_of(name);
    if (index < 0)
      joints->fail(name, "unknown joint", name, "a joint of the URDF: " + joint_names(model.tree));
    read_joint(*joints->table(name), model.joints[static_cast<std::size_t>(index)]);
  }
}

void append_joint(std::ostringstream& out, const JointSettings& settings,
                  const JointSettings* only_different_from) {
  const auto* base = only_different_from;
  if (base == nullptr || base->actuator != settings.actuator) {
    out << "actuator = " << files::toml_quoted(recording::to_string(settings.actuator)) << "\n";
  }
  std::vector<double> base_values;
  if (base != nullptr) {
    JointSettings::visit(*base, [&](std::string_view, double v, std::string_view, double, double) {
      base_values.push_back(v);
    });
  }
  std::size_t k = 0;
  JointSettings::visit(
      settings, [&](std::string_view key, double value, std::string_view unit, double, double) {
        if (base == nullptr || base_values[k] != value) {
          out << key << " = " << files::toml_number(value) << "  # " << unit << "\n";
        }
        ++k;
      });
}

}  // namespace

const char* to_string(GroundKind kind) {
  switch (kind) {
    case GroundKind::plane:
      return "plane";
    case GroundKind::ramp:
      return "ramp";
    case GroundKind::jump_ramp:
      return "jump_ramp";
    case GroundKind::heights:
      return "heights";
  }
  return "plane";
}

ModelFolder parse_model(std::string_view toml, std::string_view urdf, const std::string& name) {
  const TomlTable top = TomlTable::parse(toml, name);
  ModelFolder model;
  read_settings(top, model);
  model.urdf = urdf;
  model.tree = read_tree(model, model.urdf_file);
  read_joints(top, model);
  return model;
}

void require_fixed_base(const ModelFolder& model, const std::string& reader) {
  if (!model.floating) return;
  throw InputError((std::filesystem::path(model.folder) / "model.toml").string(), model.base_line,
                   "robot.base", "floating base", "floating",
                   "\"fixed\": " + reader +
                       " simulates no base that moves; record the robot in a stand, its base "
                       "clamped, and write base = \"fixed\" with the URDF's root in the stand");
}

ModelFolder read_model_folder(const std::string& folder) {
  const std::filesystem::path path = folder;
  if (!std::filesystem::is_directory(path)) {
    throw InputError(folder, 0, "", "no such folder", "",
                     "a folder with model.toml and robot.urdf");
  }
  const std::string toml_path = (path / "model.toml").string();
  const TomlTable top = TomlTable::read(toml_path);
  ModelFolder model;
  model.folder = folder;
  read_settings(top, model);
  const std::string urdf_path = (path / model.urdf_file).string();
  model.urdf = files::read_text(urdf_path);
  model.tree = read_tree(model, urdf_path);
  read_joints(top, model);
  return model;
}

std::string robot_text(const ModelFolder& model) {
  using files::toml_number;
  using files::toml_quoted;
  std::ostringstream out;
  out << "format = 1\n\n[robot]\nurdf = " << toml_quoted(model.urdf_file) << "\nbase = \""
      << (model.floating ? "floating" : "fixed") << "\"\ngravity = ["
      << toml_number(model.gravity[0]) << ", " << toml_number(model.gravity[1]) << ", "
      << toml_number(model.gravity[2]) << "]  # m/s^2, world axes\n\n"
      << "[control]\nperiod_s = " << toml_number(model.period_s) << "\n\n[joint_default]\n";
  append_joint(out, model.joint_default, nullptr);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    if (model.joints[k] == model.joint_default) continue;
    out << "\n[joint." << files::toml_key(model.tree.joints[k].name) << "]\n";
    append_joint(out, model.joints[k], &model.joint_default);
  }
  return out.str();
}

std::string ground_text(const ModelFolder& model) {
  return "\n[ground]\nkind = " + files::toml_quoted(to_string(model.ground_kind)) +
         "\nfriction = " + files::toml_number(model.ground_friction) + "\n";
}

std::string effects_text(const ModelFolder& model) {
  using files::toml_number;
  using files::toml_quoted;
  std::ostringstream out;
  for (const EffectEntry& effect : model.effects) {
    out << "\n[[effect]]\nid = " << toml_quoted(effect.id) << "\nwhere = [";
    for (std::size_t k = 0; k < effect.where.size(); ++k)
      out << (k == 0 ? "" : ", ") << toml_quoted(effect.where[k]);
    out << "]\n";
    for (const auto& [name, value] : effect.parameters) {
      out << files::toml_key(name) << " = " << toml_number(value) << "\n";
    }
  }
  return out.str();
}

std::string model_toml(const ModelFolder& model) {
  return robot_text(model) + (model.floating ? ground_text(model) : std::string()) +
         effects_text(model);
}

void write_model_folder(const ModelFolder& model, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  files::write_atomically(std::filesystem::path(folder) / model.urdf_file, model.urdf);
  files::write_atomically(std::filesystem::path(folder) / "model.toml", model_toml(model));
}

}  // namespace sanso::diagnose
