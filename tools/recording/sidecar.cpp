// The keys of the sidecar in one place for reading and writing; an unknown key is an error.
#include "tools/recording/sidecar.h"

#include <limits>
#include <map>
#include <sstream>

#include "shared/files/atomic_file.h"
#include "shared/files/toml.h"
#include "tools/recording/joint_settings.h"

namespace sanso::recording {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

void read_joint_table(const files::TomlTable& table, const std::string& name,
                      Recording& recording) {
  std::vector<std::string_view> known{"actuator"};
  JointSettings settings;
  JointSettings::visit(
      settings, [&](std::string_view key, double, std::string_view, double low, double high) {
        known.push_back(key);
        if (const auto value = table.number(key, low, high)) {
          recording.overrides.push_back({name, std::string(key), {*value}, "", table.line_of(key)});
        }
      });
  table.allow_only(known);
  if (const auto actuator = table.string("actuator")) {
    if (!actuator_from(*actuator)) {
      table.fail("actuator", "unknown actuator", *actuator,
                 "torque, position_pd, dc_servo or passive");
    }
    recording.overrides.push_back({name, "actuator", {}, *actuator, table.line_of("actuator")});
  }
}

void read_payload(const files::TomlTable& table, Recording& recording) {
  table.allow_only({"link", "mass", "com"});
  Payload payload;
  const auto link = table.string("link");
  const auto mass = table.number("mass", 0.0, kInf);
  if (!link) table.fail("link", "missing key", "", "the name of the link that carries the payload");
  if (!mass) table.fail("mass", "missing key", "", "kg");
  payload.link = *link;
  payload.mass = *mass;
  if (const auto com = table.numbers("com", 3)) payload.com = {(*com)[0], (*com)[1], (*com)[2]};
  recording.payloads.push_back(payload);
}

void read(const files::TomlTable& top, Recording& recording) {
  top.allow_only({"recording", "robot", "control", "joint_default", "joint", "payload"});
  if (const auto table = top.table("recording")) {
    table->allow_only({"condition"});
    recording.condition = table->string("condition").value_or("");
  }
  if (const auto table = top.table("robot")) {
    table->allow_only({"gravity"});
    if (const auto g = table->numbers("gravity", 3)) {
      recording.overrides.push_back({"robot", "gravity", *g, "", table->line_of("gravity")});
    }
  }
  if (const auto table = top.table("control")) {
    table->allow_only({"period_s"});
    if (const auto period = table->number("period_s", 1e-5, 10.0)) {
      recording.overrides.push_back(
          {"control", "period_s", {*period}, "", table->line_of("period_s")});
    }
  }
  if (const auto table = top.table("joint_default"))
    read_joint_table(*table, "joint_default", recording);
  if (const auto joints = top.table("joint")) {
    for (const std::string& name : joints->keys())
      read_joint_table(*joints->table(name), "joint." + name, recording);
  }
  for (const files::TomlTable& table : top.tables("payload")) read_payload(table, recording);
}

}  // namespace

void parse_sidecar(std::string_view text, const std::string& name, Recording& recording) {
  read(files::TomlTable::parse(text, name), recording);
}

void read_sidecar(const std::string& path, Recording& recording) {
  read(files::TomlTable::read(path), recording);
}

void write_sidecar(const Recording& recording, const std::string& path) {
  std::ostringstream out;
  out << "# set differently in this recording\n";
  if (!recording.condition.empty())
    out << "[recording]\ncondition = " << files::toml_quoted(recording.condition) << "\n";
  std::map<std::string, std::vector<const Override*>> tables;  // one header a table
  for (const Override& o : recording.overrides) tables[o.table].push_back(&o);
  for (const auto& [table, settings] : tables) {
    const bool joint = table.starts_with("joint.");
    out << "[" << (joint ? "joint." + files::toml_key(table.substr(6)) : table) << "]\n";
    for (const Override* o : settings) {
      out << o->key << " = ";
      if (!o->text.empty()) {
        out << files::toml_quoted(o->text);
      } else if (o->numbers.size() == 1) {
        out << files::toml_number(o->numbers[0]);
      } else {
        for (std::size_t k = 0; k < o->numbers.size(); ++k)
          out << (k == 0 ? "[" : ", ") << files::toml_number(o->numbers[k]);
        out << "]";
      }
      out << "\n";
    }
  }
  for (const Payload& p : recording.payloads) {
    out << "[[payload]]\nlink = " << files::toml_quoted(p.link)
        << "\nmass = " << files::toml_number(p.mass) << "\ncom = [" << files::toml_number(p.com[0])
        << ", " << files::toml_number(p.com[1]) << ", " << files::toml_number(p.com[2]) << "]\n";
  }
  files::write_atomically(path, out.view());
}

}  // namespace sanso::recording
