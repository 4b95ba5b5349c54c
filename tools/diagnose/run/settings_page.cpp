// Walks the settings' visit(): one line of the page, or one check, a setting.
#include "tools/diagnose/run/settings_page.h"

#include <fmt/format.h>

#include <stdexcept>

namespace sanso::diagnose {

std::string settings_page() {
  std::string page =
      "# Settings of the diagnosis\n\n"
      "Made from `tools/diagnose/settings.h` by `sanso-diagnose-settings-page`; a test compares.\n"
      "No command takes them from a person, but `remains.horizon` and `remains.matters`, which\n"
      "say what the person needs: an answer that depends on them is no answer. What half and\n"
      "double of one does is measured by `sanso bench diagnose --setting NAME=FACTOR`\n"
      "([results](results/diagnose.md)).\n";
  Settings settings;
  settings.visit([&](const char* group, auto& section) {
    page += fmt::format(
        "\n## {}\n\n| name | default | range | unit | why |\n|---|---|---|---|---|\n", group);
    section.visit([&](const char* key, auto& value, const char* unit, auto low, auto high,
                      const char* reason) {
      page += fmt::format("| `{}.{}` | {:g} | {:g} .. {:g} | {} | {} |\n", group, key,
                          static_cast<double>(value), static_cast<double>(low),
                          static_cast<double>(high), unit, reason);
    });
  });
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
