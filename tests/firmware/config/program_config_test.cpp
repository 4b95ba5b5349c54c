// The configuration file: every setting by name, every mistake named with file, line, value and
// what was expected; and the settings page is the one that the structs make.
#include "firmware/config/program_config.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "firmware/config/key_file.h"
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
      "[device]\nbus = \"/dev/pts/3\"\nport = 9000\n[guard]\nmax_temperature_C = 70\n",
      "robot.toml", config, error))
      << error;
  EXPECT_EQ(config.device.bus, "/dev/pts/3");
  EXPECT_EQ(config.device.port, 9000);
  EXPECT_EQ(config.settings.guard.max_temperature_C, 70.0);
}

TEST(ProgramConfig, SettingsThatContradictEachOtherAreNamed) {
  const std::pair<const char*, const char*> cases[] = {
      {"[guard]\nlow_voltage_V = 9.0\n", "guard.low_voltage_V"},
      {"[guard]\nwarm_temperature_C = 76\n", "guard.warm_temperature_C"},
      {"[guard]\nmax_duty = 0.3\n", "guard.hot_duty"},
      {"[guard]\nfall_tilt_rad = 0.4\n", "guard.tilt_limit_rad"},
      {"[imu]\nlate_s = 0.06\n", "imu.late_s"},
      {"[imu]\nsilent_s = 0.025\nperiod_s = 0.01\n", "imu.silent_s"},
      {"[bus]\nreply_timeout_s = 0.008\n", "bus.reply_timeout_s"},
      {"[imu]\nquat_base_sensor_w = 0.0\n", "imu.quat_base_sensor_w"}};
  for (const auto& [text, named] : cases)
    EXPECT_EQ(error_of(text).rfind(std::string("robot.toml: ") + named, 0), 0u) << error_of(text);
}

TEST(KeyFile, MustBelongToItsOwnerAloneAndBeAKey) {
  namespace fs = std::filesystem;
  std::string name = (fs::temp_directory_path() / "sanso_key_XXXXXX").string();
  const fs::path folder = mkdtemp(name.data());
  const fs::path file = folder / "robot.key";
  wire::Key key;
  std::string error;
  const auto read = [&](const std::string& digits, fs::perms mode) {
    std::ofstream(file) << digits;
    fs::permissions(file, mode);
    return read_key_file(file, key, error);
  };
  const auto own = fs::perms::owner_read | fs::perms::owner_write;
  EXPECT_FALSE(read_key_file(folder / "missing", key, error));
  EXPECT_TRUE(read(std::string(63, '1') + "2\n", own)) << error;
  EXPECT_FALSE(read(std::string(64, '1'), own | fs::perms::group_read));
  EXPECT_NE(error.find("0640"), std::string::npos) << error;
  EXPECT_FALSE(read(std::string(64, '1'), own | fs::perms::others_write));
  EXPECT_FALSE(read(std::string(64, '0'), own));
  EXPECT_FALSE(read("not a key", own));
  fs::remove_all(folder);
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
