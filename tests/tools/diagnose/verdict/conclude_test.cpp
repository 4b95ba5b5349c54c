// From the search's result to findings.
#include "tools/diagnose/verdict/conclude.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/small_world.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/explain/rivals.h"

namespace sanso::diagnose {
namespace {

CandidateParameter parameter(const char* name, double null, bool structural = false) {
  CandidateParameter p;
  p.name = name;
  p.null = null;
  p.structural = structural;
  return p;
}

TEST(SpansNull, OneFittedParameterBesideItsNullIsEnough) {
  Candidate c;
  c.parameters = {parameter("resistance", 1.0), parameter("torque", 1.0),
                  parameter("mode", 0.0, true)};
  std::map<std::string, VerdictParameter> found{{"resistance", {0.89, 0.85, 0.94, "-", false}},
                                                {"torque", {1.01, 0.95, 1.07, "-", false}},
                                                {"mode", {1.0, 1.0, 1.0, "-", false}}};
  EXPECT_FALSE(spans_null(c, found));
  // what is chosen and not fitted has no interval
  found["resistance"] = {0.89, 0.78, 1.0, "-", false};
  EXPECT_TRUE(spans_null(c, found));
  found["torque"] = {1.07, 0.95, 1.07, "-", true};  // a bound that stopped it is another reserve
  EXPECT_FALSE(spans_null(c, found));
}

TEST(SpansNull, AChoiceWithoutFittedParametersHasNoInterval) {
  Candidate c;
  c.parameters = {parameter("mode", 0.0, true)};
  EXPECT_FALSE(spans_null(c, {{"mode", {0.0, 0.0, 0.0, "-", false}}}));
}

TEST(SpansNull, ChanceIsJudgedByItsSize) {
  Candidate c;
  c.random = true;
  c.parameters = {parameter("share", 0.0, true), parameter("seed", 0.0, true)};
  EXPECT_FALSE(spans_null(
      c, {{"share", {0.02, 0.01, 0.03, "-", false}}, {"seed", {1.0, 1.0, 1.0, "-", false}}}));
  EXPECT_TRUE(spans_null(
      c, {{"share", {0.02, 0.0, 0.03, "-", false}}, {"seed", {1.0, 1.0, 1.0, "-", false}}}));
}

TEST(SpansNull, WhereAStopBeginsIsNotHowHardItIs) {
  Candidate c;
  c.parameters = {parameter("position", 0.0), parameter("stiffness", 0.0)};
  c.parameters[0].role = Role::position;
  const VerdictParameter place{0.9, 0.87, 0.93, "rad", false};
  EXPECT_TRUE(spans_null(c, {{"position", place}, {"stiffness", {2.0, 0.0, 4.0, "-", false}}}));
  EXPECT_FALSE(spans_null(c, {{"position", place}, {"stiffness", {2.0, 1.0, 3.0, "-", false}}}));
}

/// Two recordings of two joints: together 2 rad at the first, 0.1 rad at the second.
Comparison two_short_motions() {
  Comparison c;
  c.sources.resize(2);
  c.sources[0].motion.q = {{-1.0, 0.0, 0.5}, {0.0, 0.1, 0.0}};
  c.sources[1].motion.q = {{1.0, 0.5, 0.0}, {0.0, 0.0, 0.05}};
  return c;
}

TEST(Unrepeated, IsARippleOfWhichTheRecordingsSeeTooFewPeriods) {
  const Comparison c = two_short_motions();
  Candidate ripple;
  ripple.joints = {0};
  ripple.parameters = {parameter("sine", 0.0), parameter("order", 2.0, true)};
  ripple.parameters[1].role = Role::order;
  const double least = std::numbers::pi * c.settings.library.periods;
  EXPECT_TRUE(unrepeated(c, ripple, {0.1, 0.99 * least}));
  EXPECT_FALSE(unrepeated(c, ripple, {0.1, 1.01 * least}));
  ripple.joints = {0, 1};  // one number for both, and one of them hardly moves
  EXPECT_TRUE(unrepeated(c, ripple, {0.1, 1.01 * least}));
  ripple.parameters[1].role = Role::size;
  EXPECT_FALSE(unrepeated(c, ripple, {0.1, 2.0}));
}

TEST(Unrepeated, IsNoName) {
  Finding f;
  f.effect = "cogging";
  f.one_of = {"cogging", "joint_stop"};
  f.unrepeated = true;
  EXPECT_EQ(status_of(f), VerdictStatus::present_unnamed);
  EXPECT_NE(reserve(f).find("too few periods"), std::string::npos);
}

Finding found(const char* effect, const char* family, const char* where, double gain) {
  Finding f;
  f.effect = effect;
  f.family = family;
  f.where = {where};
  f.one_of = {effect};
  f.heldout_gain = gain;
  return f;
}

VerdictStatus status_of_first(std::vector<Finding> findings) {
  return status_of(with_their_kind(std::move(findings), DecisionSettings{}).front());
}

/// Dry friction and a ripple of it that was not seen to repeat are one friction that bends over the
/// angle; what stands at another joint, or is of another kind, is not.
TEST(OneKind, IsOneLawWithARippleThatNobodySawRepeat) {
  const Finding dry = found("coulomb_friction", "friction", "knee", 0.3);
  Finding ripple = found("position_friction", "friction", "knee", 0.5);
  EXPECT_EQ(status_of_first({dry, ripple}), VerdictStatus::confirmed);
  ripple.unrepeated = true;
  EXPECT_EQ(status_of_first({dry, ripple}), VerdictStatus::present_unnamed);
  const std::vector<Finding> both = with_their_kind({dry, ripple}, DecisionSettings{});
  EXPECT_NE(reserve(both.front()).find("bends over the angle"), std::string::npos);
  EXPECT_NE(reserve(both.back()).find("too few periods"), std::string::npos);
  ripple.tolerated = true;  // told in a note, and no finding
  EXPECT_EQ(status_of_first({dry, ripple}), VerdictStatus::confirmed);
  ripple.tolerated = false;
  ripple.where = {"hip"};
  EXPECT_EQ(status_of_first({dry, ripple}), VerdictStatus::confirmed);
  ripple.where = dry.where;
  ripple.family = "sensor";
  EXPECT_EQ(status_of_first({dry, ripple}), VerdictStatus::confirmed);
}

/// What follows the acceleration is no bend over the angle, of whatever family it is.
TEST(OneKind, AnInertiaIsNoPartOfWhatBendsOverTheAngle) {
  Finding error = found("gear_kinematic_error", "transmission", "knee", 0.5);
  error.unrepeated = true;
  const Finding rotor = found("rotor_inertia", "transmission", "knee", 0.3);
  const Finding play = found("backlash", "transmission", "knee", 0.3);
  EXPECT_EQ(status_of_first({rotor, error}), VerdictStatus::confirmed);
  EXPECT_EQ(status_of_first({play, error}), VerdictStatus::present_unnamed);
}

/// Of whatever kind it is: a friction whose law falls otherwise leaves what a spring removes.
TEST(OneJoint, HasNoNameForWhatALargerLawMayBeOffBy) {
  const double share = DecisionSettings{}.rest_of_joint;
  Finding large = found("stribeck_friction", "friction", "knee", 0.5);
  large.joints = {1};
  Finding more = found("joint_compliance", "transmission", "knee", 1.1 * share * 0.5);
  more.joints = {1};
  EXPECT_EQ(status_of_first({more, large}), VerdictStatus::confirmed);
  Finding less = more;
  less.heldout_gain = 0.9 * share * 0.5;
  EXPECT_EQ(status_of_first({less, large}), VerdictStatus::present_unnamed);
  EXPECT_EQ(status_of_first({large, less}), VerdictStatus::confirmed);
  EXPECT_NE(reserve(with_their_kind({less, large}, DecisionSettings{}).front())
                .find("stribeck_friction is off by"),
            std::string::npos);
  less.chance = true;  // judged by its scatter, not by the error it removes
  EXPECT_EQ(status_of_first({less, large}), VerdictStatus::confirmed);
  less.chance = false;
  less.where = {"shank"};  // the link that hangs at it
  EXPECT_EQ(status_of_first({less, large}), VerdictStatus::present_unnamed);
  less.where = {"hip"}, less.joints = {0};
  EXPECT_EQ(status_of_first({less, large}), VerdictStatus::confirmed);
  less.joints = large.joints = {};  // a supply and its battery are the whole robot's
  EXPECT_EQ(status_of_first({less, large}), VerdictStatus::confirmed);
}

/// What a larger finding leaves is no noise, so that a smaller one, of whatever kind and place, has
/// to be of a surer size. The larger one has nothing beside it to be a part of, and a set names no
/// one for sure.
TEST(Beside, ASmallerGainHasToBeOfACertainSize) {
  const Finding large = found("supply_sag", "electrical", "knee", 0.5);
  Finding small = found("servo_d_gain", "servo", "hip", 0.1);
  EXPECT_EQ(status_of_first({small, large}), VerdictStatus::confirmed);
  small.nearly_null = true;
  EXPECT_EQ(status_of_first({small, large}), VerdictStatus::present_unnamed);
  EXPECT_EQ(status_of_first({large, small}), VerdictStatus::confirmed);
  EXPECT_EQ(status_of_first({small}), VerdictStatus::confirmed);
  EXPECT_NE(reserve(with_their_kind({small, large}, DecisionSettings{}).front())
                .find("sure beside supply_sag"),
            std::string::npos);
  small.one_of = {"servo_d_gain", "sensor_delay"};
  EXPECT_EQ(status_of_first({small, large}), VerdictStatus::one_of);
  EXPECT_EQ(reserve(with_their_kind({small, large}, DecisionSettings{}).front()), "");
}

/// An interval that ends at a quarter of the size contains the null when it is twice as wide.
TEST(Beside, TwiceTheIntervalIsAskedForTheNull) {
  Candidate c;
  CandidateParameter size;
  size.name = "viscous";
  c.parameters = {size};
  const std::map<std::string, VerdictParameter> wide{{"viscous", {0.1, 0.025, 0.175, "-", false}}};
  const std::map<std::string, VerdictParameter> narrow{{"viscous", {0.1, 0.06, 0.14, "-", false}}};
  EXPECT_FALSE(spans_null(c, wide));
  EXPECT_TRUE(spans_null(c, wide, 2.0));
  EXPECT_FALSE(spans_null(c, narrow, 2.0));
}

Candidate at(const char* effect, std::size_t joint) {
  Candidate c;
  c.effect = effect;
  c.joints = {joint};
  return c;
}

/// On one joint any load is a sum of two masses; on the second of two joints the first one's motion
/// tells them apart.
TEST(Terms, AMassIsATermOfALoadOnlyWhereItsJointHangsOnTheBase) {
  const auto tree = test::arm("actuator = \"passive\"").tree.joints;
  EXPECT_EQ(terms_of(at("payload", 0), tree), kOfAngle | kOfAcceleration);
  EXPECT_EQ(terms_of(at("payload", 1), tree), 0U);
  EXPECT_EQ(terms_of(at("tether", 0), tree), unsigned{kOfAngle});
  // of its own joint, wherever that hangs
  EXPECT_EQ(terms_of(at("cable_spring", 1), tree), unsigned{kOfAngle});
  EXPECT_EQ(terms_of(at("rotor_inertia", 1), tree), unsigned{kOfAcceleration});
  EXPECT_EQ(terms_of(at("coulomb_friction", 0), tree), 0U);
  // sliding springs: one of them and many
  EXPECT_EQ(terms_of(at("presliding_friction", 1), tree), unsigned{kOfSlip});
  EXPECT_EQ(terms_of(at("maxwell_slip_friction", 0), tree), unsigned{kOfSlip});
}

}  // namespace
}  // namespace sanso::diagnose
