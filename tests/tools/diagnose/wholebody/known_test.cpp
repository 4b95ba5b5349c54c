// [[effect]] entries of a floating base: what a diagnosis writes is what the next one reads, and
// what cannot be is refused with its place.
#include <gtest/gtest.h>

#include "shared/files/input_error.h"
#include "tests/tools/diagnose/wholebody/made_body.h"
#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {
namespace {

using namespace test;

std::string entry(std::string_view id, const std::string& where, const std::string& numbers) {
  return "[[effect]]\nid = \"" + std::string(id) + "\"\n" +
         (where.empty() ? "" : "where = [\"" + where + "\"]\n") + numbers;
}

std::string refusal(const std::string& more, const char* urdf = kTwoLegs) {
  try {
    WholeBody body = body_of(more, urdf);
    apply_effects(body);
  } catch (const files::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(KnownEffects, OfAModelAreWhatAPatchWrites) {
  Patch patch;
  patch.pose_scale = 1.02, patch.mass_share = 0.1;
  patch.slope = V2(0.01, -0.02), patch.pose_tilt = V2(-0.005, 0.003);
  patch.gyro_bias = V3(0.01, 0, -0.02), patch.acc_bias = V3(0, 0.3, 0);
  const WholeBody made = patched(body_of("", kTwoLegs), patch);
  WholeBody again = parse_whole_body(whole_body_toml(made), kTwoLegs, "again");
  const double mass = again.base.mass;
  const Known known = apply_effects(again);
  EXPECT_EQ(known.pose_scale, 1.02);
  EXPECT_EQ(known.slope, V2(0.01, -0.02));
  EXPECT_EQ(known.pose_tilt, V2(-0.005, 0.003));
  EXPECT_EQ(known.gyro_bias, V3(0.01, 0, -0.02));
  EXPECT_EQ(known.acc_bias, V3(0, 0.3, 0));
  EXPECT_EQ(known.force_scale, 1.0);
  EXPECT_NEAR(again.base.mass, 1.1 * mass, 1e-12);
}

TEST(KnownEffects, AddUpWithWhatWasKnownBefore) {
  Patch patch;
  patch.mass_share = 0.5, patch.slope = V2(0.01, 0.0);
  const WholeBody twice = patched(patched(body_of("", kTwoLegs), patch), patch);
  ASSERT_EQ(twice.model.effects.size(), 2u) << "one entry a name and place";
  WholeBody body = twice;
  const double mass = body.base.mass;
  const Known known = apply_effects(body);
  EXPECT_NEAR(body.base.mass, 1.5 * 1.5 * mass, 1e-12) << "shares multiply";
  EXPECT_NEAR(known.slope[0], 0.02, 1e-15) << "leans add";
}

TEST(KnownEffects, OfDrivesAreTheKeysThatTheyAre) {
  const std::string drives =
      "[joint_default]\nactuator = \"position_pd\"\nkp = 100\nviscous = 0.5\ncoulomb = 0.2\n";
  Patch patch;
  patch.entries = {{"servo_p_gain", {"l"}, {{"gain", 0.8}}, 0},
                   {"viscous_friction", {"l", "r"}, {{"viscous", 0.25}}, 0},
                   {"coulomb_friction", {"r"}, {{"coulomb", -0.1}}, 0}};
  WholeBody body = patched(patched(body_of(drives, kTwoLegs), patch), patch);
  apply_effects(body);
  const JointSettings &l = body.model.joints[0], &r = body.model.joints[1];
  EXPECT_NEAR(l.kp, 64.0, 1e-12) << "gains multiply";
  EXPECT_EQ(r.kp, 100.0);
  EXPECT_NEAR(l.viscous, 1.0, 1e-12) << "frictions add";
  EXPECT_NEAR(r.viscous, 1.0, 1e-12);
  EXPECT_NEAR(r.coulomb, 0.0, 1e-12);
  EXPECT_EQ(l.coulomb, 0.2);
  EXPECT_NE(refusal(drives + entry("coulomb_friction", "l", "coulomb = -0.5\n")), "")
      << "friction that drives";
}

TEST(KnownEffects, ThatNoFloatingBaseHasAreRefusedWithThoseThatItHas) {
  for (const Effect& effect : library()) {
    const bool can = (effect.drive && effect.drive->placed) ||
                     (effect.whole != WholeFigure::none && effect.whole <= WholeFigure::slope);
    const std::string where = effect.scope == Scope::joint ? "l" : "trunk";
    const std::string told = refusal(entry(effect.id, where, ""));
    if (can) {
      EXPECT_EQ(told, "") << effect.id;
      EXPECT_NE(refusal(entry(effect.id, where, "no_such = 1.0\n")), "") << effect.id;
    } else {
      EXPECT_NE(told.find("not simulated on a floating base"), std::string::npos) << effect.id;
      EXPECT_NE(told.find(name_of(WholeFigure::payload)), std::string::npos) << told;
    }
  }
}

TEST(KnownEffects, ThatCannotBeAreRefused) {
  for (const std::string& bad :
       {entry("link_mass", "trunk", "share = -1.0\n"),
        entry("pose_scale", "trunk", "scale = 0.0\n"),
        entry("foot_force_scale", "trunk", "scale = -1.0\n"),
        entry("link_com", "nobody", "x = 0.1\n"), entry("payload", "", "mass = 0.1\n"),
        entry("servo_p_gain", "trunk", "gain = 0.9\n")})
    EXPECT_NE(refusal(bad), "") << bad;
}

TEST(KnownEffects, OfALinkChangeItsBodyAndNothingElse) {
  WholeBody body = body_of(entry("payload", "l_foot", "mass = 0.5\nz = -0.1\n") +
                               entry("link_com", "r_foot", "x = 0.02\n"),
                           kTwoLegs);
  const WholeBody before = body;
  apply_effects(body);
  const BodyInertia &l = body.model.tree.joints[0].body, &r = body.model.tree.joints[1].body;
  EXPECT_NEAR(l.mass, 1.0, 1e-12);
  EXPECT_NEAR(l.com[2], -0.05, 1e-12) << "halfway to the payload, which weighs as much";
  EXPECT_NEAR(r.com[0], 0.02, 1e-12);
  EXPECT_EQ(r.mass, before.model.tree.joints[1].body.mass);
  EXPECT_EQ(body.base.mass, before.base.mass);
}

}  // namespace
}  // namespace sanso::diagnose
