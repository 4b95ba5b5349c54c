// Walks the settings' visit(): one line of the page, or one check, a setting.
#include "tools/diagnose/run/settings_page.h"

#include <fmt/format.h>

#include <stdexcept>

namespace sanso::diagnose {
namespace {

template <class Group>
std::string group_table(const char* name, Group& group) {
  std::string out = fmt::format(
      "\n## {}\n\n| name | default | range | unit | why |\n|---|---|---|---|---|\n", name);
  group.visit(
      [&](const char* key, auto& value, const char* unit, auto low, auto high, const char* reason) {
        out += fmt::format("| `{}.{}` | {:g} | {:g} .. {:g} | {} | {} |\n", name, key,
                           static_cast<double>(value), static_cast<double>(low),
                           static_cast<double>(high), unit, reason);
      });
  return out;
}

}  // namespace

std::string settings_page() {
  std::string page =
      "# Settings of the diagnosis\n\n"
      "Made from `tools/diagnose/settings.h` by `sanso-diagnose-settings-page`; a test compares.\n"
      "No command takes them from a person, but `remains.horizon` and `remains.matters`, which\n"
      "say what the person needs: an answer that depends on them is no answer. What half and\n"
      "double of one does is measured by `sanso bench diagnose --setting NAME=FACTOR`\n"
      "([results](results/diagnose.md)).\n";
  Settings settings;
  settings.visit([&](const char* group, auto& section) { page += group_table(group, section); });
  return page;
}

void require_in_range(Settings settings) {
  settings.visit([&](const char* group, auto& section) {
    section.visit(
        [&](const char* key, auto& value, const char* unit, auto low, auto high, const char*) {
          if (value >= low && value <= high) return;
          throw std::invalid_argument(fmt::format("setting {}.{} = {}: expected {} .. {} ({})",
                                                  group, key, value, low, high, unit));
        });
  });
}

}  // namespace sanso::diagnose
