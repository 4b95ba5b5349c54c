// Names that leave, names that are exchanged, and the simpler of two that explain the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/support/standing_search.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(Prune, ANameThatIsNotNeededLeaves) {
  for (const Names& order : {Names{"viscous_friction", "coulomb_friction"},
                             Names{"coulomb_friction", "viscous_friction"}}) {
    Standing s({kRubbing}, order);
    const double before = s.state.found.final_heldout.sum();
    backward(s.state, 0);
    EXPECT_EQ(s.names(), Names{"coulomb_friction"});
    EXPECT_TRUE(s.said("no longer needed: " + s.c.library[s.c.of("viscous_friction")].title()));
    EXPECT_NEAR(s.state.found.final.model.effects[0].theta[0], 0.08, 0.01);
    EXPECT_LT(s.state.found.final_heldout.sum(), 1.05 * before) << "it cost no prediction";
  }
}

TEST(Prune, ANameThatWasJustJudgedIsLeftAlone) {
  Standing s({kRubbing}, {"coulomb_friction", "viscous_friction"});
  backward(s.state, 1);
  EXPECT_EQ(s.names(), (Names{"coulomb_friction", "viscous_friction"}));
  Standing other({kRubbing}, {"viscous_friction", "coulomb_friction"});
  backward(other.state, 1);
  EXPECT_EQ(other.names(), Names{"coulomb_friction"});
}

TEST(Prune, TwoThatAreBothThereStay) {
  Standing s({kRubbing, kSpring}, {"coulomb_friction", "cable_spring"});
  backward(s.state, 0);
  EXPECT_EQ(s.names(), (Names{"coulomb_friction", "cable_spring"}));
  drop_refuted(s.state);
  EXPECT_EQ(s.names(), (Names{"coulomb_friction", "cable_spring"}));
  EXPECT_TRUE(s.state.found.refuted.empty());
}

/// Or a set would lack a name that was far behind only beside what has left since.
TEST(Prune, RivalsThatWereJudgedBesideANameThatLeftAreJudgedAgain) {
  Standing s({kRubbing}, {"coulomb_friction", "viscous_friction"});
  Alternative rival;
  rival.candidate = s.c.of("cable_spring");
  rival.fit.model = s.state.found.final.model;
  rival.fit.model.effects.erase(rival.fit.model.effects.begin());
  std::vector<double> theta;
  for (const CandidateParameter& p : s.c.library[rival.candidate].parameters)
    theta.push_back(p.null + p.typical);
  rival.fit.model.effects.push_back({rival.candidate, theta});
  backward(s.state, 0);
  ASSERT_EQ(s.names(), Names{"coulomb_friction"});
  std::vector<Alternative>& rivals = s.state.found.accepted[0].alternatives;
  rivals = {rival};  // as good as the name, as far as anybody has looked
  follow_level_rivals(s.state, 0);
  ASSERT_EQ(rivals[0].fit.model.effects.size(), 1U);
  EXPECT_EQ(rivals[0].fit.model.effects[0].candidate, rival.candidate);
  EXPECT_TRUE(beaten(s.state.decisions(), rivals[0].behind, s.state.practical()))
      << "a spring does not rub";
}

TEST(Prune, OfARobotAsItsModelNothingStays) {
  Standing s({}, {"coulomb_friction", "cable_spring"});
  backward(s.state, 0);
  EXPECT_EQ(s.names(), Names{});
  EXPECT_TRUE(s.state.found.final.model.effects.empty());
  EXPECT_NEAR(s.state.found.final_heldout.sum(), s.state.found.nominal_heldout.sum(),
              0.01 * s.state.found.nominal_heldout.sum());
}

const std::vector<std::string> kOfLoad{"gear_efficiency", "load_friction",
                                       "directional_load_friction", "coulomb_friction"};

TEST(State, WhatChanceExplainsIsTheSameInOtherUnits) {
  Standing s({}, {});
  s.state.found.expected_scatter = Eigen::VectorXd::Ones(s.state.found.final.r.size());
  Screening louder;
  louder.scales = s.state.problem.scales;
  for (double& sigma : louder.scales.sigma) sigma *= 2.0;
  s.state.calibrate(louder);
  EXPECT_NEAR(s.state.found.expected_scatter.minCoeff(), 0.25, 1e-12);
  EXPECT_NEAR(s.state.found.expected_scatter.maxCoeff(), 0.25, 1e-12);
}

TEST(State, WhatWasContradictedIsNotAskedAgain) {
  Standing s({}, {"viscous_friction"});
  const std::size_t spring = s.c.of("cable_spring");
  const auto holds = [spring](const std::vector<std::size_t>& all) {
    return std::count(all.begin(), all.end(), spring) == 1;
  };
  EXPECT_TRUE(holds(s.state.asked()));
  s.state.given_up.push_back(spring);
  EXPECT_FALSE(holds(s.state.asked()));
  EXPECT_TRUE(holds(s.state.open()));
  EXPECT_EQ(s.state.asked().size() + 1, s.state.open().size());
}

TEST(State, WhatLeftTwiceIsNotAskedAThirdTime) {
  Standing s({kRubbing}, {"coulomb_friction"});
  const std::size_t damper = s.c.of("viscous_friction");
  const auto asked = [&] {
    const std::vector<std::size_t> all = s.state.asked();
    return std::count(all.begin(), all.end(), damper) == 1;
  };
  s.state.leaves(damper);
  EXPECT_TRUE(asked()) << "beside other names it may be needed";
  s.state.leaves(damper);
  EXPECT_FALSE(asked());
}

TEST(OneForTwo, OneFrictionOfTwoNumbersTakesThePlaceOfTwoOfOne) {
  Standing s({hidden("directional_load_friction", "a", {{"drive", 0.3}, {"backdrive", 0.05}})},
             {"gear_efficiency", "load_friction"}, kOfLoad);
  const double before = s.state.found.final_heldout.sum();
  one_for_two(s.state);
  EXPECT_EQ(s.names(), Names{"directional_load_friction"});
  EXPECT_TRUE(s.said("in the place of"));
  EXPECT_LT(s.state.found.final_heldout.sum(), 1.05 * before) << "it cost no prediction";
  EXPECT_NEAR(s.state.found.final.model.effects[0].theta[0], 0.3, 0.05);
}

TEST(OneForTwo, TwoThatAreBothThereStay) {
  // dry friction and what grows with the load have relatives in common, and none is both
  Standing s({hidden("load_friction", "a", {{"load", 0.2}}), kRubbing},
             {"load_friction", "coulomb_friction"}, kOfLoad);
  one_for_two(s.state);
  EXPECT_EQ(s.names(), (Names{"load_friction", "coulomb_friction"}));
}

const std::vector<std::string> kOfWeight{"payload", "link_mass", "encoder_offset"};

TEST(TwoForOne, AMassAndAZeroTakeThePlaceOfAPayload) {
  Standing s({hidden("link_mass", "arm", {{"share", 0.3}}),
              hidden("encoder_offset", "a", {{"offset", 0.06}})},
             {"payload"}, kOfWeight);
  const double before = s.state.found.final_heldout.sum();
  two_for_one(s.state);
  Names names = s.names();
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (Names{"encoder_offset", "link_mass"}));
  EXPECT_TRUE(s.said("in the place of payload"));
  EXPECT_LT(s.state.found.final_heldout.sum(), 1.05 * before) << "it cost no prediction";
}

TEST(TwoForOne, APayloadStays) {
  Standing s({hidden("payload", "arm", {{"mass", 0.2}, {"x", 0.08}, {"z", 0.05}})}, {"payload"},
             kOfWeight);
  two_for_one(s.state);
  EXPECT_EQ(s.names(), Names{"payload"});
}

TEST(Gate, TheLuckiestOfManyIsNoFinding) {
  // a gain that one candidate alone would prove, and the best of a dozen has by chance
  Standing s({}, {});
  Alternative a;
  a.candidate = s.c.of("coulomb_friction");
  a.fit = s.state.found.final;
  a.fit.model.effects.push_back({a.candidate, {0.08}});
  const Eigen::VectorXd& before = s.state.found.final_heldout;
  const auto with_scatter = [&](double scatter) {
    Random random(5);
    a.heldout = before;
    for (Eigen::Index i = 0; i < before.size(); ++i)
      a.heldout[i] -= 0.1 * before[i] * (1.0 + scatter * random.normal());
    return compare(*s.state.problem, before, a.heldout).beyond_chance();
  };
  double scatter = 0.1;
  ASSERT_TRUE(with_scatter(scatter));
  EXPECT_EQ(refused_by(s.state, a).find("so many candidates"), std::string::npos);
  while (with_scatter(1.02 * scatter)) scatter *= 1.02;
  ASSERT_TRUE(with_scatter(scatter)) << "by a little";
  EXPECT_NE(refused_by(s.state, a).find("so many candidates"), std::string::npos);
}

TEST(Swap, TheNameThatPredictsBetterTakesThePlace) {
  Standing s({kRubbing}, {"viscous_friction"});
  const double before = s.state.found.final_heldout.sum();
  // what was fitted in its place when it was accepted
  const Model base = nominal(s.c);
  s.state.found.accepted[0].alternatives =
      fit_all(*s.state.found.around, base, s.state.found.nominal.objective,
              {s.c.of("coulomb_friction"), s.c.of("cable_spring")}, s.state.found.first);
  swap_for_better(s.state);
  EXPECT_EQ(s.names(), Names{"coulomb_friction"});
  EXPECT_TRUE(s.said("swapped"));
  EXPECT_LT(s.state.found.final_heldout.sum(), before);
  double last = -INFINITY;
  bool keeps_the_old = false;
  for (const Alternative& a : s.state.found.accepted[0].alternatives) {
    EXPECT_NE(a.candidate, s.c.of("coulomb_friction"));
    keeps_the_old |= a.candidate == s.c.of("viscous_friction");
    EXPECT_GE(a.behind.bounded.total, last);
    last = a.behind.bounded.total;
  }
  EXPECT_TRUE(keeps_the_old) << "as a rival";
}

TEST(Swap, TheRightNameStays) {
  Standing s({kRubbing}, {"coulomb_friction"});
  s.state.found.accepted[0].alternatives =
      fit_all(*s.state.found.around, nominal(s.c), s.state.found.nominal.objective,
              {s.c.of("viscous_friction"), s.c.of("cable_spring")}, s.state.found.first);
  swap_for_better(s.state);
  EXPECT_EQ(s.names(), Names{"coulomb_friction"});
  EXPECT_FALSE(s.said("swapped"));
  for (const Alternative& a : s.state.found.accepted[0].alternatives)
    EXPECT_TRUE(beaten(s.state.decisions(), a.behind, s.state.practical()))
        << s.c.library[a.candidate].title();
}

TEST(Swap, WhatRemovesNearlyAsMuchIsFittedToTheEnd) {
  const Names tried{"coulomb_friction", "stribeck_friction", "presliding_friction",
                    "maxwell_slip_friction", "viscous_friction"};
  Standing s({kRubbing}, {"coulomb_friction"}, tried);
  swap_for_better(s.state);
  const double is = s.state.found.final.objective, without = s.state.without(0).objective;
  const double nearly = is + 0.9 * s.c.problem->settings.fitting.polish_share * (without - is);
  int near = 0;
  for (const Alternative& a : s.state.found.accepted[0].alternatives) {
    if (a.fit.objective > nearly) continue;
    ++near;
    EXPECT_FALSE(a.far_behind) << s.c.library[a.candidate].title();
  }
  EXPECT_GE(near, 2) << "frictions that slide alike";
}

TEST(Swap, WhatPredictsTheSameIsNotBehind) {
  // servo and readings late: one motion, and fits without a group end where they happen to
  Standing s({hidden("command_delay", "a", {{"delay", 0.02}})}, {"command_delay"},
             {"command_delay", "sensor_delay", "coulomb_friction"});
  swap_for_better(s.state);
  ASSERT_EQ(s.names().size(), 1U);
  bool found = false;
  for (const Alternative& a : s.state.found.accepted[0].alternatives) {
    const std::string& name = s.c.library[a.candidate].effect;
    if (name != "command_delay" && name != "sensor_delay") continue;
    found = true;
    EXPECT_EQ(a.behind.removed(), 0.0);
    EXPECT_LE(a.behind.certainty(), 0.0);
  }
  EXPECT_TRUE(found);
}

/// Two names of the same effects: one with a single number, one with three.
struct TwoNames {
  TwoNames() {
    library.candidates.resize(2);
    library.candidates[0].parameters.resize(3);
    library.candidates[1].parameters.resize(3);
    // what stays as the probe says is no number of the fit
    library.candidates[1].parameters[1].structural = true;
    library.candidates[1].parameters[2].structural = true;
  }
  /// Who wins when the simple name leaves `more` energy in every shot, give or take `scatter`.
  std::size_t winner(const Problem& problem, double more, double scatter) const {
    Alternative rich, simple;
    rich.candidate = 0, simple.candidate = 1;
    rich.heldout = Eigen::VectorXd::Constant(60, 100.0);
    simple.heldout = rich.heldout;
    for (Eigen::Index i = 0; i < 60; ++i)
      simple.heldout[i] += more + scatter * std::sin(12.9 * static_cast<double>(i));
    std::vector<Alternative> all{rich, simple};
    rank(library, problem, all);
    return all.front().candidate;
  }
  Library library;
};

TEST(Rank, TheSimplerNameIsKeptWithinNoise) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 42);
  const TwoNames names;
  const double practical = practical_energy(*c.problem) / 60.0;
  EXPECT_EQ(names.winner(c.problem, 0.0, 0.1), 1U);
  EXPECT_EQ(names.winner(c.problem, 0.5 * practical, 0.01), 1U) << "sure, and does not matter";
  EXPECT_EQ(names.winner(c.problem, 1.5 * practical, 80.0), 1U) << "matters, and is not sure";
  EXPECT_EQ(names.winner(c.problem, 10.0 + 5.0 * practical, 1.0), 0U) << "worse, surely";
  EXPECT_EQ(names.winner(c.problem, -10.0, 1.0), 1U) << "simpler and better";
}

TEST(Rank, WhatNoRowShowsIsNoNumberAndWhatIsSearchedIsOne) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 42);
  Library library;
  library.candidates.resize(2);
  for (Candidate& candidate : library.candidates) candidate.parameters.resize(3);
  const auto winner = [&](double unseen_variance) {
    std::vector<Alternative> all(2);
    for (std::size_t i = 0; i < 2; ++i) {
      all[i].candidate = i;
      all[i].fit.parameters = 3;
      all[i].fit.covariance = Eigen::MatrixXd::Identity(4, 4);
      all[i].heldout = Eigen::VectorXd::Constant(60, 100.0 + static_cast<double>(i));
    }
    all[1].fit.covariance(1, 1) = unseen_variance;
    rank(library, c.problem, all);
    return all.front().candidate;
  };
  EXPECT_EQ(winner(1.0), 0U) << "as many numbers, and it predicts a little better";
  EXPECT_EQ(winner(1e6), 1U) << "the same with a number fewer";
  Candidate ripple;
  ripple.parameters.resize(3);
  ripple.parameters[2].structural = true;
  EXPECT_EQ(free_parameters(ripple), 2);
  ripple.parameters[2].role = Role::order;
  EXPECT_EQ(free_parameters(ripple), 3) << "an order that was searched";
}

TEST(Beaten, NeedsToBeSureAndToMatter) {
  const DecisionSettings decisions;
  HeldoutGain behind;
  behind.energy = {100.0, 10.0, 80.0}, behind.bounded = {50.0, 50.0, -40.0};
  EXPECT_TRUE(beaten(decisions, behind, 90.0)) << "one measure suffices";
  EXPECT_FALSE(beaten(decisions, behind, 110.0)) << "does not matter";
  behind.energy.standard_error = 60.0;
  EXPECT_FALSE(beaten(decisions, behind, 90.0)) << "neither is sure";
  behind.bounded.standard_error = 5.0;
  EXPECT_TRUE(beaten(decisions, behind, 90.0)) << "nor does the other have to be";
  behind.energy.total = -100.0;
  EXPECT_FALSE(beaten(decisions, behind, 0.0)) << "who predicts better is not beaten";
}

TEST(Beaten, TheBestOfManyHasToBeFartherAhead) {
  const DecisionSettings decisions;
  EXPECT_EQ(errors_ahead(decisions, 1), decisions.standard_errors);
  EXPECT_EQ(errors_ahead(decisions, 0), decisions.standard_errors);
  double before = decisions.standard_errors;
  for (const std::size_t rivals : {2u, 4u, 8u, 16u}) {
    const double ahead = errors_ahead(decisions, rivals);
    EXPECT_GT(ahead, before);
    before = ahead;
    // by chance, of so many that are as good one stands so far behind
    EXPECT_NEAR(normal_tail(ahead) * static_cast<double>(rivals),
                normal_tail(decisions.standard_errors), 1e-6);
  }
  HeldoutGain behind;
  behind.energy = behind.bounded = {100.0, 40.0, 20.0};  // 2.45 deviations
  EXPECT_TRUE(beaten(decisions, behind, 0.0));
  EXPECT_TRUE(beaten(decisions, behind, 0.0, 2));
  EXPECT_FALSE(beaten(decisions, behind, 0.0, 8));
}

TEST(Pair, OneWhoseOwnFitWasLostIsAcceptedByItself) {
  // both are missing, and each would have been named alone, had its fit not ended elsewhere: the
  // other is asked of the step after
  Standing s({kRubbing, kSpring}, {}, {"coulomb_friction", "cable_spring"});
  std::vector<Alternative> lost(2);
  lost[0].candidate = s.c.of("coulomb_friction"), lost[1].candidate = s.c.of("cable_spring");
  for (Alternative& a : lost) a.fit.objective = INFINITY;
  ASSERT_TRUE(accept_pair(s.state, 0, s.state.found.first, lost, s.state.practical()));
  EXPECT_EQ(s.names().size(), 1U);
  ASSERT_EQ(forward(s.state, 1), Forward::found);
  std::vector<std::string> both = s.names();
  std::sort(both.begin(), both.end());
  EXPECT_EQ(both, (std::vector<std::string>{"cable_spring", "coulomb_friction"}));
}

TEST(Forward, WhatIsAcceptedWasHeldAgainstAllThatItStoodFor) {
  // one place for a rival: what looks like it, and the same effect at both joints, stand behind it
  SmallComparison c =
      compared(two_links(kNoisyServo), {hidden("gear_efficiency", "a", {{"efficiency", 0.85}})},
               {"gear_efficiency", "load_friction", "viscous_friction"}, 7, 3);
  Comparison changed = *c.problem;
  changed.settings.decisions.rivals = 1;
  c.problem.comparison = std::make_shared<const Comparison>(std::move(changed));
  const SelectOptions options;
  SearchState state(c.problem, c.library, options);
  Selection& found = state.found;
  found.around = make_surroundings(state.problem, c.library, nominal(c));
  found.nominal = fit(*found.around, nominal(c), 3);
  found.final.model = nominal(c);
  found.first = screen(*found.around, found.nominal.model, found.nominal.r, c.all(), Random(1));
  state.relinearise();
  ASSERT_EQ(forward(state, 0), Forward::found);
  const Accepted& accepted = found.accepted.front();
  EXPECT_EQ(state.accepted(0).title(), "gear_efficiency at a");
  const Settings& settings = c.problem->settings;
  EXPECT_GE(
      stood_for(settings, c.library, found.first, state.practical(), accepted.candidate, {}).size(),
      1U);
  EXPECT_TRUE(stood_for(settings, c.library, found.first, state.practical(), accepted.candidate,
                        accepted.alternatives)
                  .empty());
  for (const Alternative& a : accepted.alternatives)
    EXPECT_GE(a.fit.objective, found.final.objective - kNoiseUnit)
        << c.library[a.candidate].title();
}

}  // namespace
}  // namespace sanso::diagnose
