// Every setting of the diagnosis can be halved and doubled for the table of docs/results: in a
// copy, and only by a proper factor inside the setting's range.
#include "tools/bench/diagnose/scaled_setting.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace sanso::bench {
namespace {

using diagnose::Settings;

TEST(ScaledSetting, ScalesRealAndWholeNumbersOfACopy) {
  const Settings settings;
  EXPECT_EQ(scaled(settings, "decisions.family_wise=0.5").decisions.family_wise,
            0.5 * settings.decisions.family_wise);
  EXPECT_EQ(scaled(settings, "decisions.rivals=2").decisions.rivals, 2 * settings.decisions.rivals);
  EXPECT_EQ(scaled(settings, "decisions.rivals=0.01").decisions.rivals, 1)
      << "a count stays at least one";
  EXPECT_EQ(settings.decisions.rivals, Settings{}.decisions.rivals);
  EXPECT_EQ(value_of(scaled(settings, "decisions.rivals=2"), "decisions.rivals"),
            2.0 * settings.decisions.rivals);
  EXPECT_THROW(value_of(settings, "decisions.nothing"), std::invalid_argument);
}

TEST(ScaledSetting, RefusesUnknownNamesAndBadFactors) {
  for (const char* bad :
       {"decisions.nothing=2", "family_wise=2", "kFamilyWise=2", "decisions.family_wise",
        "decisions.family_wise=", "decisions.family_wise=0", "decisions.family_wise=-1",
        "decisions.family_wise=inf", "=2", ""}) {
    EXPECT_THROW(scaled({}, bad), std::invalid_argument) << bad;
  }
}

TEST(ScaledSetting, SaysNameValueAndRangeOfWhatLeavesItsRange) {
  try {
    scaled({}, "decisions.family_wise=100");
    FAIL() << "a level of 1 was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(),
                 "setting decisions.family_wise = 1: expected 1e-06 .. 0.5 (probability)");
  }
}

TEST(ScaledSetting, EverySettingCanBeHalvedAndDoubledByANameOfItsOwn) {
  const std::vector<std::string> names = setting_names();
  EXPECT_GT(names.size(), 40u);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  for (const std::string& name : names) {
    EXPECT_NO_THROW(scaled({}, name + "=0.5")) << name;
    EXPECT_NO_THROW(scaled({}, name + "=2")) << name;
  }
}

}  // namespace
}  // namespace sanso::bench
