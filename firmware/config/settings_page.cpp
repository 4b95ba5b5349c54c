// Visits every settings struct, so that the page holds exactly the names, units, defaults and
// ranges that the program reads.
#include "firmware/config/settings_page.h"

#include <sstream>

#include "firmware/config/settings.h"

namespace sanso::firmware {

std::string settings_page() {
  std::ostringstream page;
  page << "# Settings of the onboard controller\n\n"
          "Made from `firmware/config/settings.h` by `sanso-settings-page`; a test compares. All "
          "of them may stand in the file "
          "given to\n`sanso-firmware --config FILE` (TOML, one section a group); what is missing "
          "keeps its default. A unit "
          "ends the name; rates\nand noises say theirs in the text. An unknown name or a value "
          "outside its range stops the "
          "program with file, line and value.\n\n"
          "The section `[device]` names devices and addresses: `bus`, `imu`, `pose`, `listen`, "
          "`port`, `key_file`, "
          "`offsets`, `log_directory`,\n`log_file_MB`, `log_file_minutes`, `log_keep_MB`, "
          "`tick_priority`, `allow_without_realtime`, `robot_name` "
          "(`firmware/config/program_config.h`).\n\n"
          "Planner and session have theirs in [settings-learn](settings-learn.md).\n";
  Settings settings;
  settings.visit([&](const char* section, auto& group) {
    page << "\n## [" << section << "]\n\n| name | default | range | meaning |\n|---|---|---|---|\n";
    group.visit([&](const char* key, auto& value, auto low, auto high, const char* meaning) {
      page << std::boolalpha << "| `" << key << "` | " << value << " | " << low << " .. " << high
           << " | " << meaning << " |\n";
    });
  });
  return page.str();
}

}  // namespace sanso::firmware
