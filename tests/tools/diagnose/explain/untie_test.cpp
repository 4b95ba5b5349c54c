// An effect tied over joints and a second term that takes it back at one of them.
#include "tools/diagnose/explain/untie.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_comparison.h"
#include "tools/diagnose/settings.h"

namespace sanso::diagnose {
namespace {

ModelFolder robot() {
  return test::two_links("actuator = \"position_pd\"\nkp = 12\nkd = 0.3\nposition_noise = 1e-3\n");
}

/// Three recordings of the two links in a world with `hidden`, and the library's `effects` on them.
struct Bench : test::SmallComparison {
  Bench(const std::vector<EffectEntry>& hidden, const std::vector<std::string>& effects)
      : SmallComparison(robot(), recordings(hidden),
                        {{"q:a", 0.0, 1e-3, {}}, {"q:b", 0.0, 1e-3, {}}}, effects) {}

  static std::vector<recording::Recording> recordings(const std::vector<EffectEntry>& hidden) {
    const ModelFolder world = test::hiding(robot(), hidden);
    std::vector<recording::Recording> out;
    for (int i = 0; i < 3; ++i) {
      const Drive drive = test::make_test_drive(world, 6.0, 0.01, [i](int joint, double t) {
        return 0.7 * std::sin((3.3 + 0.4 * i + joint) * t) +
               0.3 * std::sin((7.1 + 0.7 * i - joint) * t);
      });
      out.push_back(test::record(world, drive,
                                 {.file = "made_" + std::to_string(i) + ".csv",
                                  .noise_seed = 5 + static_cast<std::uint64_t>(i)}));
    }
    return out;
  }
};

TEST(Untie, TakesATiedEffectAndWhatStandsInsideItApart) {
  const Bench b({}, {"link_inertia", "coulomb_friction", "rotor_inertia"});
  Model model;
  model.effects = {{b.of("link_inertia", {0, 1}), {0.6}},
                   {b.of("coulomb_friction", {0, 1}), {0.1}},
                   {b.of("link_inertia", {1}), {-0.6}}};
  const std::vector<Untied> apart = untied(b.library, model, Settings{}.decisions.maximum_effects);
  ASSERT_EQ(apart.size(), 1U);  // the friction is tied too, with nothing of its kind beside it
  EXPECT_EQ(apart[0].replaced, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(apart[0].stay, std::vector<std::size_t>{1});
  ASSERT_EQ(apart[0].model.effects.size(), 3U);
  EXPECT_EQ(apart[0].model.effects[0].candidate, b.of("coulomb_friction", {0, 1}));
  EXPECT_EQ(apart[0].model.effects[1].candidate, b.of("link_inertia", {0}));
  EXPECT_EQ(apart[0].model.effects[2].candidate, b.of("link_inertia", {1}));
  EXPECT_EQ(apart[0].model.effects[2].theta, std::vector<double>{0.6});
  // a documented twin of it inside counts as well; the effect over the same joints does not
  model.effects.back().candidate = b.of("rotor_inertia", {1});
  EXPECT_EQ(untied(b.library, model, Settings{}.decisions.maximum_effects).size(), 1U);
  model.effects.back().candidate = b.of("rotor_inertia", {0, 1});
  EXPECT_TRUE(untied(b.library, model, Settings{}.decisions.maximum_effects).empty());
}

TEST(Untie, ANumberForEachJointTakesThePlaceOfATermAtItsBound) {
  Bench b({{"link_inertia", {"upper"}, {{"share", 0.5}}},
           {"link_inertia", {"lower"}, {{"share", 0.15}}}},
          {"link_inertia"});
  const Model tied{{{b.of("link_inertia", {0, 1}), {0.5}}, {b.of("link_inertia", {1}), {-0.5}}},
                   {}};
  b.problem = step_corrected(b.problem, b.library, tied);
  const Surroundings around = make_surroundings(b.problem, b.library, tied);
  const FitResult pair = fit(around, tied, Settings{}.fitting.iterations);
  const std::optional<FitResult> apart = fit_untied(
      around, untied(b.library, pair.model, Settings{}.decisions.maximum_effects).front(), pair);
  ASSERT_TRUE(apart);
  EXPECT_NEAR(apart->model.effects[0].theta[0], 0.5, 0.06);
  EXPECT_NEAR(apart->model.effects[1].theta[0], 0.15, 0.06);
}

TEST(Untie, TwoEffectsThatAreBothThereStayTwo) {
  const Bench b({{"coulomb_friction", {"a", "b"}, {{"coulomb", 0.1}}},
                 {"backlash", {"b"}, {{"width", 0.05}}}},
                {"coulomb_friction", "backlash"});
  const Surroundings around = make_surroundings(b.problem, b.library, Model{});
  constexpr double kEncoderAtLink = 0.0;
  const Model start{
      {{b.of("coulomb_friction", {0, 1}), {0.1}}, {b.of("backlash", {1}), {0.05, kEncoderAtLink}}},
      {}};
  const FitResult pair = fit(around, start, Settings{}.fitting.iterations);
  const std::vector<Untied> apart =
      untied(b.library, pair.model, Settings{}.decisions.maximum_effects);
  ASSERT_EQ(apart.size(), 1U);
  EXPECT_FALSE(fit_untied(around, apart.front(), pair));
}

TEST(Untie, ARefitWithoutAGroupPredictsItAsTheLinearStepSays) {
  const Bench b({{"link_inertia", {"upper"}, {{"share", 0.1}}}}, {"link_inertia"});
  const Surroundings around = make_surroundings(b.problem, b.library, Model{});
  const FitResult found =
      fit(around, Model{{{b.of("link_inertia", {0}), {0.0}}}, {}}, Settings{}.fitting.iterations);
  const double linear = heldout_energy(around, found).sum(),
               refitted = refitted_energy(around, found).sum();
  const double seen = around.bounded(around.starts.energy_by_shot(found.r)).sum();
  EXPECT_GT(refitted, seen);  // what a fit has not seen it predicts worse
  EXPECT_NEAR(refitted, linear, 0.1 * linear);
}

}  // namespace
}  // namespace sanso::diagnose
