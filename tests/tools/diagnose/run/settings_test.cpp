// The settings of the diagnosis: the page shows them all as they are, and a value outside its range
// is refused by name.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/run/settings_page.h"

namespace sanso::diagnose {
namespace {

TEST(DiagnoseSettings, PageIsMadeFromTheSettings) {
  std::ifstream file("docs/settings-diagnose.md");
  ASSERT_TRUE(file) << "tests run from the top of the repository";
  std::stringstream page;
  page << file.rdbuf();
  EXPECT_EQ(page.str(), settings_page())
      << "write it again: sanso-diagnose-settings-page > docs/settings-diagnose.md";
}

TEST(DiagnoseSettings, DefaultsAreInsideTheirRangesAndEveryOneSaysWhy) {
  EXPECT_NO_THROW(require_in_range({}));
  Settings settings;
  settings.visit([](const char*, auto& group) {
    group.visit([](const char* key, auto&, const char* unit, auto low, auto high, const char* why) {
      EXPECT_LT(low, high) << key;
      EXPECT_NE(std::string(unit), "") << key;
      EXPECT_GT(std::string(why).size(), 8U) << key;
    });
  });
}

TEST(DiagnoseSettings, HalfAndTwiceAreAllowedWhereTheyAreRun) {
  for (const double factor : {0.5, 2.0}) {
    Settings settings;
    const auto scale = [&](const char* key, auto& value, const char*, auto low, auto high,
                           const char*) {
      const double scaled = factor * static_cast<double>(value);
      EXPECT_GE(scaled, static_cast<double>(low)) << key;
      EXPECT_LE(scaled, static_cast<double>(high)) << key;
      value = static_cast<std::decay_t<decltype(value)>>(scaled);
    };
    settings.base.visit(scale), settings.whole.visit(scale);
    settings.smoother.visit(scale), settings.library.visit(scale), settings.simulation.visit(scale);
    EXPECT_NO_THROW(require_in_range(settings));
  }
}

TEST(DiagnoseSettings, OutOfRangeAndNotANumberAreRefusedBeforeAnythingRuns) {
  DiagnoseOptions options;
  options.settings.data.shot_seconds = NAN;
  EXPECT_THROW(diagnose(options, [](const std::string&) { FAIL() << "something ran"; }),
               std::invalid_argument);
  options.settings = {};
  options.settings.decisions.rivals = 0;
  try {
    diagnose(options, [](const std::string&) { FAIL() << "something ran"; });
    FAIL() << "no rivals at all were accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "setting decisions.rivals = 0: expected 1 .. 1000 (candidates)");
  }
}

}  // namespace
}  // namespace sanso::diagnose
