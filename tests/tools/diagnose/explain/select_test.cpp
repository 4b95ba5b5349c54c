// The search: nothing in clean data, what was hidden at the joint where it was, never a worse
// prediction of what was held out; what an explanation promises has to have happened.
#include "tools/diagnose/explain/select.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/explain/incidence.h"
#include "tools/diagnose/explain/regimes.h"
#include "tools/diagnose/explain/steps.h"

namespace sanso::diagnose {
namespace {

using namespace test;

const std::vector<std::string> kTried{"coulomb_friction", "viscous_friction", "cable_spring",
                                      "command_delay"};

/// A comparison and what the search made of it.
struct Searched {
  explicit Searched(SmallComparison comparison)
      : c(std::move(comparison)), selection(select(c.problem, c.library, SelectOptions{})) {}
  const Candidate& name(std::size_t i) const { return c.library[selection.accepted[i].candidate]; }
  std::string names() const {
    std::string all;
    for (std::size_t i = 0; i < selection.accepted.size(); ++i) all += name(i).title() + "; ";
    return all;
  }
  SmallComparison c;
  Selection selection;
};

TEST(Select, KeepsNothingOfCleanData) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Searched s(compared(pendulum(kNoisyServo), {}, kTried, seed));
    EXPECT_TRUE(s.selection.accepted.empty()) << "seed " << seed << ": " << s.names();
    EXPECT_TRUE(s.selection.final.model.effects.empty());
  }
}

TEST(Select, KeepsNothingOfARobotWithinItsTolerances) {
  // one percent more mass at the elbow, and a resistance warmer by a few kelvin: calibrations
  ModelFolder world = two_links(kNoisyServo);
  world.tree.joints[1].body.mass *= 1.01;
  for (JointSettings& joint : world.joints) joint.resistance *= 1.01;
  const ModelFolder model = two_links(kNoisyServo);
  const Searched s(
      SmallComparison(model, recordings_of(world, 2, 4.0, 4), noise_of(model), kTried));
  EXPECT_TRUE(s.selection.accepted.empty()) << s.names();
}

TEST(Select, TellsAZeroOfTheRecordFromOneOfTheServo) {
  for (const double of_record : {0.0, 1.0}) {
    const double offset = of_record > 0.0 ? -0.01 : 0.08;  // of the servo it only moves gravity
    const Searched s(compared(
        pendulum(kNoisyServo),
        {hidden("link_com", "arm", {{"x", 0.012}}),
         hidden("encoder_offset", "a", {{"offset", offset}, {"of_record", of_record}})},
        {"encoder_offset", "link_com", "cable_spring", "coulomb_friction", "tether"}, 5, 3));
    const auto zero = std::find_if(
        s.selection.final.model.effects.begin(), s.selection.final.model.effects.end(),
        [&](const Chosen& e) { return s.c.library[e.candidate].effect == "encoder_offset"; });
    ASSERT_NE(zero, s.selection.final.model.effects.end()) << of_record << ": " << s.names();
    EXPECT_EQ(zero->theta[1], of_record) << s.names();
    if (of_record > 0.0) {
      EXPECT_NEAR(zero->theta[0], offset, 0.001);
    }
  }
}

TEST(Select, NamesWhatWasHiddenAtTheJointWhereItWas) {
  for (const std::string joint : {"a", "b"}) {
    const Searched s(compared(two_links(kNoisyServo),
                              {hidden("coulomb_friction", joint, {{"coulomb", 0.09}})}, kTried, 5));
    ASSERT_EQ(s.selection.accepted.size(), 1u) << s.names();
    EXPECT_EQ(s.name(0).effect, "coulomb_friction");
    EXPECT_EQ(s.name(0).where, std::vector<std::string>{joint});
    const double sigma = std::max(s.selection.accepted[0].sigma[0], 0.002);
    EXPECT_NEAR(s.selection.final.model.effects[0].theta[0], 0.09, 4.0 * sigma);
  }
}

/// What is told from a name after a few steps of its fit is told from it beyond chance, or it would
/// be missing in the set: nothing that is far behind may be level by what it has seen.
TEST(Select, LeavesFarBehindNothingThatTheDataDoNotTellFromTheName) {
  const std::vector<std::string> tried{"coulomb_friction", "load_friction", "gear_efficiency",
                                       "stribeck_friction"};
  int names = 0, followed = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Searched s(compared(pendulum(kNoisyServo),
                              {hidden("coulomb_friction", "a", {{"coulomb", 0.004}})}, tried, seed,
                              3));
    const Surroundings& around = *s.selection.around;
    const Eigen::VectorXd seen = around.bounded(around.starts.energy_by_shot(s.selection.final.r));
    for (const Accepted& name : s.selection.accepted) {
      ++names;
      for (const Alternative& a : name.alternatives) {
        const HeldoutGain behind = compare(*around.problem, a.heldout, seen);
        const bool beyond =
            beaten(around.settings().decisions, behind, practical_energy(*around.problem));
        followed += static_cast<int>(!a.far_behind);
        EXPECT_TRUE(!a.far_behind || beyond) << s.c.library[a.candidate].title();
      }
    }
  }
  EXPECT_GT(names, 0);
  EXPECT_GT(followed, 0);
}

class OneHidden : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new Searched(compared(pendulum(kNoisyServo),
                                    {hidden("coulomb_friction", "a", {{"coulomb", 0.08}})}, kTried,
                                    6, 3));
  }
  static void TearDownTestSuite() { delete shared_; }
  const Selection& selection() const { return shared_->selection; }
  static Searched* shared_;
};
Searched* OneHidden::shared_ = nullptr;

TEST_F(OneHidden, IsFound) { ASSERT_EQ(selection().accepted.size(), 1u) << shared_->names(); }

TEST_F(OneHidden, NeverRaisesTheHeldOutError) {
  EXPECT_LT(selection().final_heldout.sum(), selection().nominal_heldout.sum());
  for (const Accepted& a : selection().accepted) {
    EXPECT_TRUE(a.gain.beyond_chance());
    EXPECT_GE(a.gain.energy.total, a.gain.energy.lower);
  }
}

TEST_F(OneHidden, PassesEveryGateItWasNamedBy) {
  for (const Accepted& a : selection().accepted) {
    EXPECT_LE(a.p_family, Settings{}.decisions.family_wise);
    EXPECT_EQ(a.contradicted, "");
    for (const char bound : a.at_bound) EXPECT_EQ(bound, 0);
    EXPECT_EQ(a.sigma.size(), selection().final.model.effects[0].theta.size());
  }
}

TEST_F(OneHidden, WithoutItTheModelIsTheNominalOne) {
  EXPECT_TRUE(selection().accepted[0].without.model.effects.empty());
  EXPECT_GT(selection().accepted[0].without.objective, selection().final.objective);
}

TEST_F(OneHidden, RivalsAreBestFirstAndNoneIsAheadOfTheName) {
  const std::vector<Alternative>& all = selection().accepted[0].alternatives;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_NE(all[i].candidate, selection().accepted[0].candidate);
    EXPECT_GE(all[i].similarity, 0.0);
    EXPECT_LE(all[i].similarity, 1.0 + 1e-6);
  }
}

TEST_F(OneHidden, WhatItPromisesHappenedOnce) {
  const Regimes regimes = find_regimes(*shared_->c.problem);
  const std::vector<IncidenceRow> rows =
      incidence(*selection().around, regimes, selection().accepted[0].without, selection().final);
  ASSERT_FALSE(rows.empty());
  for (const IncidenceRow& row : rows) {
    EXPECT_GT(row.high, 0.8) << to_string(row.residual);
    EXPECT_LT(row.low, 1.25) << to_string(row.residual);
    EXPECT_LE(row.low, row.slope);
    EXPECT_GE(row.high, row.slope);
  }
  EXPECT_EQ(refuted_by(rows, DecisionSettings{}), "");
}

TEST_F(OneHidden, APromiseOfTheOppositeIsRefuted) {
  // with and without exchanged and the model's change turned round: what is promised never happened
  FitResult without = selection().accepted[0].without, with = selection().final;
  with.r = 2.0 * without.r - with.r;
  const auto rows =
      incidence(*selection().around, find_regimes(*shared_->c.problem), without, with);
  EXPECT_NE(refuted_by(rows, DecisionSettings{}), "");
}

TEST_F(OneHidden, IsFoundTheSameAgain) {
  const Searched again(compared(
      pendulum(kNoisyServo), {hidden("coulomb_friction", "a", {{"coulomb", 0.08}})}, kTried, 6, 3));
  EXPECT_EQ(again.names(), shared_->names());
  EXPECT_EQ(again.selection.final.model.effects[0].theta, selection().final.model.effects[0].theta);
}

/// A search at its first step, screened, nothing accepted.
struct AtFirst {
  AtFirst(const std::vector<EffectEntry>& there, const std::vector<std::string>& tried)
      : c(compared(pendulum(kNoisyServo), there, tried, 8, 3)),
        state(c.problem, c.library, options) {
    state.problem = step_corrected(state.problem, state.library, Model{});
    state.found.around = make_surroundings(state.problem, state.library, Model{});
    const Eigen::VectorXd r = prediction_error(state.problem, state.library, Model{});
    state.found.around->set_shot_scale(state.found.around->starts.energy_by_shot(r));
    state.found.first = screen(*state.found.around, Model{}, r, state.open(), Random(1));
    state.calibrate(state.found.first);
  }
  bool pair() { return accept_pair(state, 0, state.found.first, {}, state.practical()); }
  SmallComparison c;
  SelectOptions options;
  SearchState state;
};

TEST(Pairs, TwoThatAreThereAreAcceptedTogetherWithTheirSizes) {
  AtFirst s({hidden("coulomb_friction", "a", {{"coulomb", 0.08}}),
             hidden("rotor_inertia", "a", {{"armature", 0.006}})},
            {"coulomb_friction", "rotor_inertia"});
  ASSERT_TRUE(s.pair());
  ASSERT_EQ(s.state.found.accepted.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const Chosen& effect = s.state.found.final.model.effects[i];
    EXPECT_EQ(effect.candidate, s.state.found.accepted[i].candidate);
    EXPECT_LE(s.state.found.accepted[i].p_family, Settings{}.decisions.family_wise);
    const bool rubs = s.state.accepted(i).effect == "coulomb_friction";
    EXPECT_NEAR(effect.theta[0], rubs ? 0.08 : 0.006, rubs ? 0.01 : 0.001);
  }
}

TEST(Pairs, OneThatIsThereIsNotMadeTwo) {
  AtFirst s({hidden("coulomb_friction", "a", {{"coulomb", 0.08}})},
            {"coulomb_friction", "rotor_inertia", "viscous_friction", "command_delay"});
  EXPECT_FALSE(s.pair());
  EXPECT_TRUE(s.state.found.accepted.empty());
  AtFirst clean({}, {"coulomb_friction", "rotor_inertia", "viscous_friction", "command_delay"});
  EXPECT_FALSE(clean.pair());
}

TEST(Regimes, ARestingJointRestsAndAMovingOneDoesNot) {
  const ModelFolder model = pendulum(kNoisyServo);
  const Drive drive = make_test_drive(model, 6.0, 0.01, [](int, double t) {
    return t < 3.0 ? 0.0 : 0.6 * std::sin(4.0 * (t - 3.0));
  });
  const SmallComparison c(model, {record(model, drive, {.noise_seed = 3})}, noise_of(model),
                          {"coulomb_friction"});
  const Regimes regimes = find_regimes(*c.problem);
  EXPECT_GE(regimes.names.size(), 4u);
  for (std::size_t g = 0; g < regimes.names.size(); ++g) {
    ASSERT_EQ(regimes.mask[0][0][g].size(), c.problem->sources[0].drive.rows());
    if (regimes.names[g] != "reversal") continue;
    for (std::size_t row = 50; row < 250; ++row)
      EXPECT_FALSE(regimes.in(0, 0, g, row)) << "at rest nothing turns, row " << row;
  }
}

}  // namespace
}  // namespace sanso::diagnose
