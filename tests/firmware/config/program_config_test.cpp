// The configuration file: every setting by name, every mistake named with file, line, value and
// what was expected; and the settings page is the one that the structs make.
#include "firmware/config/program_config.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "firmware/config/settings_page.h"

namespace sanso::firmware {
namespace {

std::string error_of(const std::string& text) {
  ProgramConfig config;
  std::string error;
  EXPECT_FALSE(parse_program_config(text, "robot.toml", config, error)) << text;
  return error;
}

TEST(ProgramConfig, AnEmptyFileMeansTheDefaults) {
  ProgramConfig config;
  std::string error;
  ASSERT_TRUE(parse_program_config("", "robot.toml", config, error)) << error;
  EXPECT_EQ(config.settings.bus.position_p_gain_raw, 560);
}

TEST(ProgramConfig, EverySettingCanBeSet) {
  // the defaults written out and read back
  std::ostringstream text;
  Settings defaults;
  defaults.visit([&](const char* section, auto& group) {
    text << "[" << section << "]\n";
    group.visit([&](const char* key, auto& value, auto, auto, const char*) {
      text << key << " = " << std::boolalpha << value << "\n";
    });
  });
  ProgramConfig config;
  std::string error;
  EXPECT_TRUE(parse_program_config(text.str(), "robot.toml", config, error)) << error;
}

TEST(ProgramConfig, ReadsDevicesAndSettings) {
  ProgramConfig config;
  std::string error;
  ASSERT_TRUE(parse_program_config(
      "[device]\nbus = \"/dev/pts/3\"\nport = 9000\n[guard]\nmax_temperature_C = 60\n",
      "robot.toml", config, error))
      << error;
  EXPECT_EQ(config.device.bus, "/dev/pts/3");
  EXPECT_EQ(config.device.port, 9000);
  EXPECT_EQ(config.settings.guard.max_temperature_C, 60.0);
}

TEST(ProgramConfig, MistakesAreNamed) {
  EXPECT_EQ(error_of("[guard]\n\nmax_temperature_C = 99\n"),
            "robot.toml:3: out of range in 'guard.max_temperature_C': found '99.0'; "
            "expected a number from 50.0 to 85.0");
  EXPECT_EQ(error_of("[bus]\nsilent_ticks = 2.5\n"),
            "robot.toml:2: not an integer in 'bus.silent_ticks': found '2.5'; "
            "expected a whole number from 2 to 100");
  EXPECT_EQ(error_of("[bus]\nfast_sync_read = 1\n"),
            "robot.toml:2: neither true nor false in 'bus.fast_sync_read': found '1'; "
            "expected true or false");
  EXPECT_EQ(error_of("[bus]\nspeed = 1\n"),
            "robot.toml:2: unknown key in 'bus.speed': found '1'; "
            "expected one of the settings in docs/settings.md");
  EXPECT_EQ(error_of("[motor]\nx = 1\n"),
            "robot.toml:1: unknown key in 'motor': found 'a table'; "
            "expected one of the sections in docs/settings.md");
  EXPECT_NE(error_of("[guard\n").find("robot.toml:1"), std::string::npos);
}

TEST(ProgramConfig, DefaultsLieInsideTheirRanges) {
  Settings settings;
  settings.visit([](const char* section, auto& group) {
    group.visit([&](const char* key, auto& value, auto low, auto high, const char*) {
      EXPECT_GE(value, low) << section << "." << key;
      EXPECT_LE(value, high) << section << "." << key;
    });
  });
}

TEST(SettingsPage, IsCurrent) {
  std::ifstream file("docs/settings.md");
  std::stringstream page;
  page << file.rdbuf();
  EXPECT_EQ(page.str(), settings_page())
      << "run build/dev/firmware/sanso-settings-page > docs/settings.md";
}

}  // namespace
}  // namespace sanso::firmware
