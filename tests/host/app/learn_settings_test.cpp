// Settings by name: each can be set and read back, a wrong one is told with what was meant, and the
// page shows them as they are.
#include "host/app/learn_settings.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "host/app/learn_command.h"

namespace sanso::app {
namespace {

std::string error_of(const std::string& assignment) {
  LearnSettings settings;
  try {
    apply_setting(assignment, settings);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// Every setting's full name with its lowest and highest value as texts.
std::vector<std::array<std::string, 3>> all_settings() {
  LearnSettings settings;
  std::vector<std::array<std::string, 3>> all;
  settings.visit([&](const char* section, auto& group) {
    group.visit([&](const char* key, auto&, const char*, auto low, auto high, const char*) {
      std::ostringstream least, most;
      least << std::boolalpha << low, most << std::boolalpha << high;
      all.push_back({std::string(section) + "." + key, least.str(), most.str()});
    });
  });
  return all;
}

TEST(LearnSettings, EveryOneIsSetByItsNameAndChangesNothingElse) {
  std::set<std::string> names;
  for (const auto& [name, low, high] : all_settings()) {
    EXPECT_TRUE(names.insert(name).second) << name << " stands twice";
    for (const std::string& value : {low, high}) {
      LearnSettings settings;
      apply_setting(name + "=" + value, settings);
      const std::string changed = changed_settings({}, settings);
      if (name.ends_with("threads")) {
        EXPECT_EQ(changed, "") << "threads change no number";
      } else if (!changed.empty()) {
        EXPECT_EQ(changed.substr(0, name.size() + 1), name + "=");
        EXPECT_EQ(changed.find(' '), std::string::npos) << changed;
        LearnSettings again;
        apply_setting(changed, again);
        EXPECT_EQ(changed_settings(settings, again), "") << "texts read back to the same bits";
      }
    }
    EXPECT_NE(error_of(name + "=1e12"), "") << name;
    EXPECT_NE(error_of(name + "="), "") << name;
    EXPECT_NE(error_of(name + "=3x"), "") << name;
  }
  EXPECT_GT(names.size(), 50u);
}

TEST(LearnSettings, AWrongNameIsToldWithTheNearest) {
  EXPECT_NE(error_of("mpc.horizn=12").find("'mpc.horizon'"), std::string::npos);
  EXPECT_NE(error_of("learn_after_failures=2").find("'session.learn_after_failures'"),
            std::string::npos);
  EXPECT_NE(error_of("trial.quiet_tilt=1").find("'trial.quiet_tilt_rad'"), std::string::npos);
  EXPECT_NE(error_of("mpc.horizon").find("NAME=VALUE"), std::string::npos);
  EXPECT_NE(error_of("mpc.horizon=1").find("2 .. 24"), std::string::npos);
  EXPECT_NE(error_of("mpc.warm_start=1").find("true or false"), std::string::npos);
}

TEST(LearnSettings, TheCommandsOptionsReachPlannerAndSession) {
  const motion::Motion motion = motion::MotionLibrary().load("squat");
  LearnOptions options;
  options.set = {"mpc.horizon=9", "session.learn_after_failures=5", "trial.cost_limit=80",
                 "trial.quiet_rate_rad_s=0.5", "identify.population=20"};
  const LearnSettings s = settings_of(options, motion, false);
  EXPECT_EQ(s.mpc.horizon, 9);
  EXPECT_EQ(s.session.learn_after_failures, 5);
  EXPECT_EQ(s.session.trial.cost_limit, 80.0) << "after the motion's file";
  EXPECT_EQ(s.session.trial.quiet_rate_rad_s, 0.5);
  EXPECT_EQ(s.session.model.identify.search.population, 20);
  EXPECT_EQ(s.session.changed,
            "mpc.horizon=9 session.learn_after_failures=5 trial.quiet_rate_rad_s=0.5 "
            "trial.cost_limit=80 identify.population=20");
  EXPECT_EQ(settings_of({}, motion, true).session.changed, "") << "old sessions resume";
}

TEST(LearnSettings, ThePapersProfileSaysWhatThePaperSays) {
  LearnSettings s;
  apply_profile("paper", s);
  EXPECT_EQ(s.session.middle.gain_rate_factor, 1.0);
  EXPECT_FALSE(s.session.middle.start_at_reference);
  EXPECT_TRUE(s.mpc.one_noise_channel);
  EXPECT_TRUE(s.mpc.noise_over_root_dt);
  EXPECT_EQ(s.session.learn_after_failures, 0);
  EXPECT_EQ(s.session.learn_first_after, 0);
  EXPECT_EQ(s.session.profile, "paper");
  EXPECT_NE(changed_settings({}, s), "");
  LearnSettings ours;
  apply_profile("ours", ours);
  EXPECT_EQ(changed_settings({}, ours), "");
  EXPECT_THROW(apply_profile("papper", s), std::runtime_error);
}

TEST(LearnSettings, DefaultsAreInsideTheirRangesAndEveryOneSaysWhy) {
  LearnSettings settings;
  settings.visit([](const char* section, auto& group) {
    group.visit([&](const char* key, auto& value, const char* unit, auto low, auto high,
                    const char* reason) {
      EXPECT_LE(low, value) << section << "." << key;
      EXPECT_LE(value, high) << section << "." << key;
      EXPECT_NE(std::string(unit), "") << section << "." << key;
      EXPECT_GT(std::string(reason).size(), 5u) << section << "." << key;
    });
  });
}

TEST(LearnSettings, ThePageIsCurrent) {
  std::ifstream file("docs/settings-learn.md");
  ASSERT_TRUE(file) << "tests run from the top of the repository";
  std::stringstream page;
  page << file.rdbuf();
  EXPECT_EQ(page.str(), learn_settings_page())
      << "write it again: sanso-learn-settings-page > docs/settings-learn.md";
}

}  // namespace
}  // namespace sanso::app
