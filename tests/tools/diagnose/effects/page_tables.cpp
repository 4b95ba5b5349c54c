// One line of markdown an effect and a setting, straight from the declarations.
#include "tests/tools/diagnose/effects/page_tables.h"

#include <cmath>
#include <cstdio>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {
namespace {

std::string shown(double value) {
  if (value == kOff) return "off";
  if (std::isinf(value)) return "any";
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

/// A bar would end the table's cell.
std::string cell(std::string_view text) {
  std::string out;
  for (char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

}  // namespace

std::string effect_table_markdown() {
  std::string out =
      "| id | what it does | where | parameters: unit; null; bounds | documented twins |\n"
      "|---|---|---|---|---|\n";
  for (const Effect& effect : library()) {
    out += "| `" + std::string(effect.id) + "` (" + std::string(effect.code) + ") | " +
           std::string(effect.name) + ": `" + cell(effect.form) + "` | " +
           std::string(to_string(effect.scope)) + " | ";
    if (!effect.apply) out += "not simulated on a fixed base; ";
    for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
      const EffectParameter& p = effect.parameters[k];
      out += std::string(k == 0 ? "" : " · ") + "`" + std::string(p.name) + "` " + cell(p.unit) +
             "; " + shown(p.null) + "; " + shown(p.low) + " to " + shown(p.high);
    }
    out += " | ";
    std::string_view between;
    for (const Effect& twin : library()) {
      if (!documented_twin(twin.id, effect.id)) continue;
      out += std::string(between) + "`" + std::string(twin.id) + "`";
      between = ", ";
    }
    out += " |\n";
  }
  return out;
}

std::string settings_table_markdown() {
  std::string out = "| key | unit | default | range |\n|---|---|---|---|\n";
  const JointSettings defaults;
  JointSettings::visit(defaults, [&](std::string_view key, double value, std::string_view unit,
                                     double low, double high) {
    out += "| `" + std::string(key) + "` | " + std::string(unit) + " | " + shown(value) + " | " +
           shown(low) + " to " + shown(high) + " |\n";
  });
  return out;
}

}  // namespace sanso::diagnose
