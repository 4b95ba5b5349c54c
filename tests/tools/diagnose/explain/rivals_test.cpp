// Rivals for one place of a model: what is tried, and who wins.
#include "tools/diagnose/explain/rivals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tests/support/small_comparison.h"
#include "tools/diagnose/fit/imitate.h"
#include "tools/diagnose/fit/normal_equations.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kServo =
    "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\ncoulomb = 0.02\nposition_noise = "
    "3e-4\n";

/// Three recordings of a world, the library's `effects` on them, and everything fits need.
struct Bench : test::SmallComparison {
  Bench(const std::vector<EffectEntry>& hidden, const std::vector<std::string>& effects,
        bool duty = false)
      : SmallComparison(test::pendulum(kServo), recordings(hidden, duty), {{"q:a", 0.0, 3e-4, {}}},
                        effects) {}

  static std::vector<recording::Recording> recordings(const std::vector<EffectEntry>& hidden,
                                                      bool duty) {
    const ModelFolder world = test::hiding(test::pendulum(kServo), hidden);
    std::vector<recording::Recording> out;
    for (int i = 0; i < 3; ++i) {
      const Drive drive = test::make_test_drive(world, 10.0, 0.01, [i](int, double t) {
        return 0.7 * std::sin((1.3 + 0.4 * i) * t) + 0.3 * std::sin((4.1 + 0.7 * i) * t);
      });
      out.push_back(test::record(world, drive,
                                 {.file = "made_" + std::to_string(i) + ".csv",
                                  .duty = duty,
                                  .noise_seed = 31 + static_cast<std::uint64_t>(i)}));
    }
    return out;
  }
};

/// Every candidate screened and fitted, best first.
struct Race {
  Surroundings around;
  Screening seen;
  std::vector<Alternative> fitted;
  explicit Race(const Bench& b) : around(make_surroundings(b.problem, b.library, Model{})) {
    const FitResult nominal = fit(around, Model{}, 3);
    seen = screen(around, Model{}, nominal.r, b.all(), Random(1));
    fitted = fit_all(around, Model{}, nominal.objective, b.all(), seen);
    rank(b.library, b.problem, fitted);
  }
};

TEST(Rivals, TheHiddenEffectWinsAndItsIntervalLeavesTheNull) {
  Bench b({{"viscous_friction", {"a"}, {{"viscous", 0.12}}}},
          {"viscous_friction", "coulomb_friction", "cable_spring"});
  const Surroundings around = make_surroundings(b.problem, b.library, Model{});
  const FitResult nominal = fit(around, Model{}, 3);
  const Screening seen = screen(around, Model{}, nominal.r, b.all(), Random(1));
  const std::vector<std::size_t> which = rivals(Settings{}, b.library, seen, 10.0);
  ASSERT_FALSE(which.empty());
  std::vector<Alternative> fitted = fit_all(around, Model{}, nominal.objective, which, seen);
  rank(b.library, b.problem, fitted);
  EXPECT_EQ(fitted.front().candidate, b.of("viscous_friction"));
  // the damping that the motor itself gives, kt ke / R, may be wrong by its tolerance of 5 %
  EXPECT_NEAR(fitted.front().fit.model.effects.back().theta[0], 0.12, 0.05 * 1.78 * 2.49 / 5.22);
  EXPECT_TRUE(leaves_null(DecisionSettings{}, b.library, fitted.front()));
  EXPECT_FALSE(at_bound(b.library, fitted.front()));
}

TEST(Rivals, ADelayOfTheCommandAndOneOfTheSensorPredictTheSame) {
  // nothing but the joint's own encoder and its command: a shift is a shift. The fits must reach
  // it, both of them
  Bench b({{"command_delay", {"a"}, {{"delay", 0.0173}}}}, {"command_delay", "sensor_delay"});
  const Race race(b);
  ASSERT_EQ(race.fitted.size(), 2U);
  for (const Alternative& a : race.fitted)
    EXPECT_NEAR(a.fit.model.effects.back().theta[0], 0.0173, 0.001);
  EXPECT_LT(race.fitted.back().behind.removed(), practical_energy(*b.problem));
  const std::vector<std::size_t> others =
      replacements(DecisionSettings{}, b.library, race.seen, race.fitted.front().fit.model,
                   race.fitted.front().candidate, {});
  EXPECT_EQ(others, std::vector<std::size_t>{race.fitted.back().candidate});
}

// Over which angle dry friction builds up nobody states, and no two laws of it rest alike: a better
// fit by springs that slip after a tenth of a milliradian is dry friction.
TEST(Rivals, SpringsThatSlipAtOnceAreDryFriction) {
  Bench b({}, {"coulomb_friction", "maxwell_slip_friction", "viscous_friction"});
  const auto shots = static_cast<Eigen::Index>(b.problem->shots.size());
  const auto of = [&](const char* effect, const std::vector<double>& theta, double energy) {
    Alternative a;
    a.candidate = b.of(effect);
    a.fit.model.effects = {{a.candidate, theta}};
    a.heldout = Eigen::VectorXd::Constant(shots, energy);
    return a;
  };
  const auto winner = [&](double angle, const Alternative& other) {
    std::vector<Alternative> all{of("maxwell_slip_friction", {0.1, 0.1 / angle, 1.0}, 100.0),
                                 other};
    rank(b.library, b.problem, all);
    return b.name_of(all.front().candidate);
  };
  const Alternative coulomb = of("coulomb_friction", {0.1}, 200.0);
  EXPECT_EQ(winner(1e-4, coulomb), "coulomb_friction");
  EXPECT_EQ(winner(2e-3, coulomb), "maxwell_slip_friction");
  // what it is not for any of its parameters has to predict as well
  EXPECT_EQ(winner(1e-4, of("viscous_friction", {0.1}, 200.0)), "maxwell_slip_friction");
}

TEST(Imitate, ATwinSaysTheSameFromWhereverItBegins) {
  // one joint on the base: the link's inertia and the rotor's are one number
  Bench b({{"rotor_inertia", {"a"}, {{"armature", 0.003}}}},
          {"rotor_inertia", "link_inertia", "viscous_friction", "sample_hold"});
  const Surroundings around = make_surroundings(b.problem, b.library, Model{});
  const std::size_t rotor = b.of("rotor_inertia"), link = b.of("link_inertia"),
                    other = b.of("viscous_friction");
  const FitResult goal =
      fit(around, Model{{{rotor, {0.003}}}, {}}, around.settings().fitting.iterations);
  const double size = goal.model.effects[0].theta[0];
  for (const double begin : {0.0, 0.1, 0.9}) {
    const Imitation same = imitate(around, goal, 0, {link, {begin}});
    ASSERT_EQ(same.model.effects.size(), 1U);
    EXPECT_EQ(same.model.effects[0].candidate, link);
    EXPECT_EQ(same.model.nuisance, goal.model.nuisance);
    const double about_joint = 0.5 * 0.01 + 1e-6;
    EXPECT_NEAR(same.model.effects[0].theta[0] * about_joint, size, 0.02 * size) << begin;
    EXPECT_LT(same.distance, practical_energy(*b.problem)) << begin;
  }
  // friction cannot say it, wherever it begins
  EXPECT_GT(imitate(around, goal, 0, {other, {0.01}}).distance, practical_energy(*b.problem));
  // nor can what has no number to choose
  const std::size_t held = b.of("sample_hold");
  EXPECT_GT(imitate(around, goal, 0, {held, b.library[held].probes.front()}).distance,
            practical_energy(*b.problem));
}

TEST(Rivals, BothDelaysAreFoundWhereTheDutyJumpsAsTheyGrow) {
  // a reading falls before or after a jump of the command: from the wrong side no derivative leads
  // across
  constexpr double kDelay = 0.0248;
  Bench b({{"sensor_delay", {"a"}, {{"delay", kDelay}}}}, {"command_delay", "sensor_delay"}, true);
  const Race race(b);
  ASSERT_EQ(race.fitted.size(), 2U);
  for (const Alternative& a : race.fitted) {
    // a lag that is tolerated is a part of the same delay
    double delay = a.fit.model.effects.back().theta[0];
    for (std::size_t k = 0; k < b.library.nuisances.size(); ++k)
      if (b.library.nuisances[k].name == "common lag") delay += a.fit.model.nuisance.at(k);
    EXPECT_NEAR(delay, kDelay, 0.001) << b.library[a.candidate].title();
  }
  EXPECT_LT(race.fitted.back().behind.removed(), practical_energy(*b.problem));
}

TEST(Rivals, ASoftStopInTheMiddleOfTheMotionIsFound) {
  // no end of the motion shows it: the joint runs into a cable and deep beyond where it first
  // touches
  Bench b({{"joint_stop", {"a"}, {{"stiffness", 0.5}, {"position", 0.12}, {"side", 1.0}}}},
          {"joint_stop", "cable_spring", "cogging"});
  const Race race(b);
  EXPECT_EQ(race.seen.ranking().front(), b.of("joint_stop"));
  EXPECT_EQ(race.fitted.front().candidate, b.of("joint_stop"));
  EXPECT_NEAR(race.fitted.front().fit.model.effects.back().theta[0], 0.5, 0.03);
  EXPECT_NEAR(race.fitted.front().fit.model.effects.back().theta[1], 0.12, 0.02);
}

TEST(Rivals, WhatPromisesTooLittleIsNotTried) {
  Bench b({{"viscous_friction", {"a"}, {{"viscous", 0.12}}}}, {"viscous_friction"});
  const Surroundings around = make_surroundings(b.problem, b.library, Model{});
  const Screening seen = screen(around, Model{}, fit(around, Model{}, 3).r, b.all(), Random(1));
  EXPECT_TRUE(rivals(Settings{}, b.library, seen, 1e12).empty());
}

TEST(Rivals, BesideManyNamesFewerAreFitted) {
  DecisionSettings settings;
  settings.rivals = 8, settings.rivals_beside = 24;
  for (const std::size_t names : {0U, 1U, 2U, 3U}) EXPECT_EQ(most_rivals(settings, names), 8U);
  EXPECT_EQ(most_rivals(settings, 4), 6U);
  EXPECT_EQ(most_rivals(settings, 6), 4U);
  EXPECT_EQ(most_rivals(settings, 100), 1U) << "one at least";
  Bench b({{"viscous_friction", {"a"}, {{"viscous", 0.12}}}},
          {"viscous_friction", "coulomb_friction", "cable_spring", "link_mass"});
  const Surroundings around = make_surroundings(b.problem, b.library, Model{});
  const Screening seen = screen(around, Model{}, fit(around, Model{}, 3).r, b.all(), Random(1));
  Settings one;
  one.decisions.rivals_beside = 3;
  const std::vector<std::size_t> all = rivals(one, b.library, seen, 1.0, 0),
                                 few = rivals(one, b.library, seen, 1.0, 2);
  ASSERT_GT(all.size(), 1U);
  EXPECT_EQ(few, std::vector<std::size_t>{all.front()});
}

TEST(Rivals, ANumberThatNoRowShowsWasNotChosen) {
  Bench b({{"viscous_friction", {"a"}, {{"viscous", 0.12}}}}, {"viscous_friction", "cable_spring"});
  const std::size_t spring = b.of("cable_spring"), damper = b.of("viscous_friction");
  ASSERT_EQ(free_parameters(b.library[spring]), 2);
  ASSERT_EQ(free_parameters(b.library[damper]), 1);
  // two that explain the same; of the second number of the spring the data leave this variance,
  // of what a number has that moves nothing
  const auto winner = [&](double left, double unseen) {
    Comparison judged = *b.problem;
    judged.settings.decisions.unseen = unseen;
    std::vector<Alternative> all(2);
    for (std::size_t i = 0; i < 2; ++i) {
      all[i].candidate = i == 0 ? spring : damper;
      all[i].fit.parameters = free_parameters(b.library[all[i].candidate]);
      all[i].fit.covariance =
          Eigen::MatrixXd::Identity(all[i].fit.parameters, all[i].fit.parameters);
      all[i].heldout = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(b.problem->shots.size()),
                                                 i == 0 ? 1.0 : 1.0 + 1e-9);
    }
    all[0].fit.covariance(1, 1) = left / kWhisper;
    rank(b.library,
         {std::make_shared<const Comparison>(std::move(judged)), b.problem.scales,
          b.problem.correction},
         all);
    return all.front().candidate;
  };
  const double usual = DecisionSettings{}.unseen;
  EXPECT_EQ(winner(0.5 * usual, usual), damper) << "two numbers against one";
  EXPECT_EQ(winner(2.0 * usual, usual), spring) << "one against one: what explains more";
  EXPECT_EQ(winner(2.0 * usual, 4.0 * usual), damper) << "the setting decides";
}

}  // namespace
}  // namespace sanso::diagnose
