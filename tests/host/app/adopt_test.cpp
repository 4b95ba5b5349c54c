// Of a verdict only what is confirmed and has a figure goes into the planner's model; the rest is
// told with its reason.
#include "host/app/adopt.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temp_folder.h"

namespace sanso::app {
namespace {

struct Verdict {
  explicit Verdict(const std::string& text) : path(folder.path() / "verdict.json") {
    std::ofstream(path) << text;
  }
  test::TempFolder folder;
  std::filesystem::path path;
};

std::string finding(const std::string& effect, const std::string& where, const std::string& status,
                    const std::string& parameters) {
  return R"({"effect": ")" + effect + R"(", "where": [)" + where + R"(], "status": ")" + status +
         R"(", "parameters": {)" + parameters + "}}";
}

TEST(Adopt, TakesWhatIsConfirmedAndSaysWhatItLeft) {
  const Verdict v(
      "{\"findings\": [" +
      finding("servo_p_gain", "\"l_knee\"", "CONFIRMED", R"("gain": {"value": 0.5})") + "," +
      finding("link_mass", "\"body_link\"", "ONE_OF", R"("share": {"value": 0.3})") + "," +
      finding("imu_bias", "\"body_link\"", "CONFIRMED", R"("gyro_x": {"value": 0.01})") + "]}");
  const model::ModelParameters nominal = model::nominal_parameters();
  model::ModelParameters theta = nominal;
  const Adoption a = adopt(v.path, theta);
  ASSERT_EQ(a.adopted.size(), 1U);
  EXPECT_EQ(a.adopted[0], "servo_p_gain at l_knee: gain 0.5");
  ASSERT_EQ(a.left.size(), 2U);
  EXPECT_NE(a.left[0].find("its status is ONE_OF"), std::string::npos);
  EXPECT_NE(a.left[1].find("no figure for it"), std::string::npos);
  EXPECT_DOUBLE_EQ(theta.servo[9].stiffness, 0.5 * nominal.servo[9].stiffness);
  EXPECT_DOUBLE_EQ(theta.servo[3].stiffness, nominal.servo[3].stiffness);
  EXPECT_DOUBLE_EQ(theta.body[0].mass, nominal.body[0].mass);
}

TEST(Adopt, TakesASetWhoseNamesAreTheSameKilograms) {
  const auto adopted = [](const std::string& names, const std::string& rival) {
    const Verdict v(R"({"findings": [{"effect": "link_mass", "where": ["body_link"],
      "status": "ONE_OF", "one_of": [)" +
                    names + R"(], "rivals": [)" + rival +
                    R"(], "parameters": {"share": {"value": 0.25}}}]})");
    model::ModelParameters theta = model::nominal_parameters();
    const double before = theta.body[0].mass;
    const Adoption a = adopt(v.path, theta);
    EXPECT_EQ(a.adopted.size() + a.left.size(), 1U);
    return theta.body[0].mass > 1.2 * before;
  };
  const std::string both = R"("link_mass", "payload")";
  EXPECT_TRUE(adopted(both, ""));
  EXPECT_TRUE(adopted(both, R"({"effect": "payload", "where": ["body_link"]})"));
  EXPECT_FALSE(adopted(both, R"({"effect": "link_mass", "where": ["l_knee_link"]})"));
  EXPECT_FALSE(adopted(R"("link_mass", "servo_p_gain")", ""));
  EXPECT_FALSE(adopted(R"("link_mass")", ""));
}

TEST(Adopt, AFileThatIsNoVerdictIsAnError) {
  model::ModelParameters theta = model::nominal_parameters();
  for (const char* text :
       {"", "{", "[]", "{}", R"({"findings": 3})", R"({"findings": [{"effect": 3}]})",
        R"({"findings": [{"effect": "link_mass", "where": ["base"], "status": "CONFIRMED",
            "parameters": {"share": {"value": null}}}]})"}) {
    const Verdict v(text);
    EXPECT_THROW(adopt(v.path, theta), std::runtime_error) << text;
  }
  EXPECT_THROW(adopt("/nowhere/verdict.json", theta), std::runtime_error);
}

}  // namespace
}  // namespace sanso::app
