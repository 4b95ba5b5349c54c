// Drives that are not as stated are named, sized and placed; drives as stated are not accused.
#include "tools/diagnose/wholebody/drive_choice.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

struct Hidden {
  const char* effect;
  const char* parameter;
  TrueDrive drive;
  double truth;
};
const Hidden kHidden[] = {{"servo_p_gain", "gain", {.gain = 0.7}, 0.7},
                          {"servo_p_gain", "gain", {.gain = 1.4}, 1.4},
                          {"coulomb_friction", "coulomb", {.coulomb = 0.4}, 0.4},
                          {"viscous_friction", "viscous", {.viscous = 0.8}, 0.8}};

DriveChoice chosen(const Stance& stance) {
  const StanceWorld world(stance);
  const DriveBalance found = balance_drives(world.asking());
  EXPECT_TRUE(found.rows.why_not.empty()) << found.rows.why_not;
  return found.choice;
}

std::string told(const DriveChoice& choice) {
  std::string out;
  for (const std::string& line : choice.log) out += line + "\n";
  return out;
}

TEST(DriveChoice, AccusesNobodyOfARobotAsStated) {
  for (const unsigned long seed : {3ul, 4ul, 5ul}) {
    Stance stance;
    stance.seed = seed;
    const DriveChoice choice = chosen(stance);
    EXPECT_TRUE(choice.terms.empty()) << told(choice);
    EXPECT_TRUE(choice.adequate);
    EXPECT_EQ(choice.before, choice.after);
  }
}

TEST(DriveChoice, NamesWhatIsWrongWithAllDrives) {
  for (const Hidden& hidden : kHidden) {
    Stance stance;
    stance.drive = [&](int) { return hidden.drive; };
    const DriveChoice choice = chosen(stance);
    ASSERT_FALSE(choice.terms.empty()) << hidden.effect << " " << hidden.truth;
    const JudgedDriveTerm& first = choice.terms.front();
    EXPECT_EQ(first.term.effect, hidden.effect) << told(choice);
    EXPECT_EQ(first.term.where.size(), 12u) << told(choice);
    EXPECT_EQ(first.term.parameters.front(), hidden.parameter);
    const VerdictParameter& p = first.parameters.front();
    EXPECT_NEAR(p.value, hidden.truth, 0.05 * hidden.truth) << told(choice);
    EXPECT_LT(p.low, p.value);
    EXPECT_GT(p.high, p.value);
    EXPECT_LT(choice.after, choice.before);
    EXPECT_GT(first.share, 1.0 - 0.6 * 0.6);  // what the nominal model has to be off by counts too
    EXPECT_GT(first.share_low, 0.0);
    EXPECT_LE(first.share_low, first.share);
  }
}

TEST(DriveChoice, PlacesALegThatIsSofter) {
  StanceWorld names({.recordings = 0});
  std::set<std::string> left;
  Stance stance;
  stance.drive = [&](int j) {
    const std::string& name = names.body.model.tree.joints[static_cast<std::size_t>(j)].name;
    const bool softer = name.rfind("l_", 0) == 0;
    if (softer) left.insert(name);
    return TrueDrive{.gain = softer ? 0.65 : 1.0};
  };
  const DriveChoice choice = chosen(stance);
  ASSERT_EQ(left.size(), 6u);
  ASSERT_FALSE(choice.terms.empty());
  const DriveTerm& term = choice.terms.front().term;
  EXPECT_EQ(term.effect, "servo_p_gain") << told(choice);
  EXPECT_EQ(std::set<std::string>(term.where.begin(), term.where.end()), left) << told(choice);
  EXPECT_NEAR(choice.terms.front().parameters.front().value, 0.65, 0.05);
}

TEST(DriveChoice, WhatIsNotSurelyThereIsSpare) {
  for (const double gain : {0.97, 0.98, 1.02, 1.03}) {  // the tolerance is 0.02
    Stance stance;
    stance.drive = [gain](int) { return TrueDrive{.gain = gain}; };
    const StanceWorld world(stance);
    const DriveChoice choice = balance_drives(world.asking()).choice;
    EXPECT_TRUE(choice.adequate) << told(choice);
    for (const JudgedDriveTerm& term : choice.terms)
      EXPECT_TRUE(surely_there(world.asking(), term)) << gain << "\n" << told(choice);
    for (const JudgedDriveTerm& term : choice.spare)
      EXPECT_FALSE(surely_there(world.asking(), term)) << gain << "\n" << told(choice);
  }
}

TEST(DriveChoice, ALongDelayIsSizedWithoutACurrent) {
  Stance stance;
  stance.drive = [](int) { return TrueDrive{.lag = 0.04}; };
  const DriveChoice choice = chosen(stance);
  ASSERT_EQ(choice.terms.size(), 1u) << told(choice);
  EXPECT_EQ(choice.terms.front().term.effect, "command_delay") << told(choice);
  EXPECT_EQ(choice.terms.front().term.where.size(), 12u) << told(choice);
  EXPECT_NEAR(choice.terms.front().parameters.front().value, 0.04, 0.003);
}

bool among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

TEST(DriveChoice, NamesAHeavierTorsoAndThatItMayBeCarried) {
  for (const bool current : {true, false}) {
    Stance stance;
    stance.current = current;
    stance.links = [](WholeBody& body) {
      body.base.mass *= 1.3;
      for (double& i : body.base.about_com) i *= 1.3;
    };
    const DriveChoice choice = chosen(stance);
    ASSERT_EQ(choice.terms.size(), 1u) << told(choice);
    const JudgedDriveTerm& first = choice.terms.front();
    EXPECT_EQ(first.term.effect, "link_mass") << told(choice);
    EXPECT_EQ(first.term.where, std::vector<std::string>{"body_link"});
    EXPECT_NEAR(first.parameters.front().value, 0.3, 0.08);
    EXPECT_TRUE(among(first.equally_good, "payload")) << told(choice);
    EXPECT_TRUE(choice.adequate);
  }
}

TEST(DriveChoice, NamesLegsThatAreHeavier) {
  Stance stance;
  stance.current = true;
  stance.links = [](WholeBody& body) {
    for (TreeJoint& j : body.model.tree.joints) j.body.mass *= 1.4;
  };
  const DriveChoice choice = chosen(stance);
  ASSERT_FALSE(choice.terms.empty());
  EXPECT_EQ(choice.terms.front().term.effect, "link_mass") << told(choice);
  EXPECT_EQ(choice.terms.front().term.where.size(), 12u) << told(choice);
  EXPECT_NEAR(choice.terms.front().parameters.front().value, 0.4, 0.12);
}

TEST(DriveChoice, NamesACentreThatIsElsewhere) {
  Stance stance;
  stance.current = true;
  stance.links = [](WholeBody& body) { body.base.com[0] += 0.03; };
  const DriveChoice choice = chosen(stance);
  ASSERT_FALSE(choice.terms.empty());
  const JudgedDriveTerm& first = choice.terms.front();
  EXPECT_TRUE(first.term.effect == "link_com" || among(first.equally_good, "link_com"))
      << told(choice);
}

TEST(DriveChoice, NamesADelayWhereACurrentIsRecorded) {
  Stance stance;
  stance.current = true;
  stance.drive = [](int) { return TrueDrive{.lag = 0.02}; };
  const DriveChoice choice = chosen(stance);
  ASSERT_FALSE(choice.terms.empty());
  EXPECT_EQ(choice.terms.front().term.effect, "command_delay") << told(choice);
  EXPECT_NEAR(choice.terms.front().parameters.front().value, 0.02, 0.002);
}

TEST(DriveChoice, NamesATorqueConstantWhereACurrentIsRecorded) {
  for (const double truth : {0.8, 1.25}) {
    Stance stance;
    stance.current = true;
    stance.drive = [&](int) { return TrueDrive{.torque = truth}; };
    const DriveChoice choice = chosen(stance);
    ASSERT_FALSE(choice.terms.empty());
    EXPECT_EQ(choice.terms.front().term.effect, "torque_constant") << told(choice);
    EXPECT_NEAR(choice.terms.front().parameters.front().value, truth, 0.05 * truth);
  }
}

TEST(DriveChoice, NamesFrictionThatGrowsWithTheLoad) {
  Stance stance;
  stance.current = true;
  stance.drive = [](int) { return TrueDrive{.load = 0.3}; };
  const DriveChoice choice = chosen(stance);
  ASSERT_FALSE(choice.terms.empty());
  EXPECT_EQ(choice.terms.front().term.effect, "load_friction") << told(choice);
  EXPECT_NEAR(choice.terms.front().parameters.front().value, 0.3, 0.08);
}

TEST(DriveTerms, AreOfKindsLegsPairsAndSingleJoints) {
  const StanceWorld world({.recordings = 1, .seconds = 1.0});
  const Asking asking = world.asking();
  const DriveRows rows = drive_rows(asking);
  std::map<std::size_t, int> gains;
  for (const DriveTerm& t : drive_terms(asking, rows)) {
    ASSERT_EQ(t.columns.rows(), rows.columns.count());
    ASSERT_EQ(t.columns.cols(), t.size());
    ASSERT_EQ(t.low.size(), t.high.size());
    EXPECT_EQ(t.units.size(), t.parameters.size());
    for (std::size_t i = 0; i < t.low.size(); ++i) EXPECT_LT(t.low[i], t.high[i]) << t.effect;
    if (t.family != Family::mass && t.effect != name_of(WholeFigure::imu_turn)) {
      EXPECT_EQ(t.columns.cwiseAbs().sum(), static_cast<double>(t.where.size())) << t.effect;
    }
    gains[t.where.size()] += t.effect == "servo_p_gain";
    EXPECT_TRUE(t.effect != "encoder_offset" || t.where.size() == 1u) << "zeros differ";
    EXPECT_NE(t.effect, "torque_constant") << "nobody recorded a current";
  }
  EXPECT_EQ(gains[12], 1);  // all of a kind
  EXPECT_EQ(gains[6], 2);   // legs
  EXPECT_EQ(gains[2], 6);   // the same joint of both
  EXPECT_EQ(gains[1], 12);
}

TEST(DriveTerms, APayloadAtTheCentreIsMoreOfTheLink) {
  const StanceWorld world({.recordings = 1, .seconds = 1.0});
  const Asking asking = world.asking();
  const DriveRows rows = drive_rows(asking);
  const std::vector<DriveTerm> terms = drive_terms(asking, rows);
  for (const DriveTerm& payload : terms) {
    if (payload.effect != "payload") continue;
    for (const DriveTerm& mass : terms) {
      if (mass.effect != "link_mass" || mass.where != payload.where) continue;
      const Eigen::VectorXd a = mass.columns.col(0), b = payload.columns.col(0);
      EXPECT_LT((a - a.dot(b) / b.squaredNorm() * b).norm(), 1e-12) << payload.where.front();
    }
  }
}

TEST(DriveNuisances, AreDrawnToZeroByWhatANominalModelMayBeWrongBy) {
  const StanceWorld world({.recordings = 1, .seconds = 1.0});
  Asking asking = world.asking();
  const DriveRows rows = drive_rows(asking);
  const DriveNuisances before = drive_nuisances(asking, rows);
  ASSERT_EQ(before.columns.cols(), before.precision.size());
  EXPECT_GT(before.precision.minCoeff(), 0.0);
  asking.tolerances.zero *= 2.0;
  const DriveNuisances after = drive_nuisances(asking, rows);
  ASSERT_EQ(after.precision.size(), before.precision.size());
  int quartered = 0;
  for (Eigen::Index i = 0; i < after.precision.size(); ++i)
    quartered += std::abs(4.0 * after.precision[i] / before.precision[i] - 1.0) < 1e-9;
  EXPECT_EQ(quartered, rows.columns.joints) << "the zero of every encoder";
}

TEST(InWords, NamesThePlaces) {
  DriveTerm term;
  term.effect = "coulomb_friction", term.where = {"l_knee", "r_knee"};
  EXPECT_EQ(in_words(term), "coulomb_friction at l_knee, r_knee");
}

}  // namespace
}  // namespace sanso::diagnose
