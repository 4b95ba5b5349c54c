// What an effect is to other rooms, as laws of the library: columns of an effort, figures of a
// floating base, figures of a drive. A room asks for all of a kind; these are the kinds.
#include <gtest/gtest.h>

#include <set>

#include "tests/support/small_world.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/torque/inverse_effort.h"

namespace sanso::diagnose {
namespace {

constexpr EffortKind kKinds[] = {EffortKind::joint, EffortKind::ripple, EffortKind::link,
                                 EffortKind::share, EffortKind::zero};

TEST(EffortEffects, AreAskedForInAnOrderOfTheirOwn) {
  std::size_t all = 0;
  for (const EffortKind kind : kKinds) {
    std::set<int> orders;
    int before = 0;
    for (const Effect* effect : effort_effects(kind)) {
      EXPECT_TRUE(orders.insert(effect->effort.order).second) << effect->id;
      EXPECT_GE(effect->effort.order, before) << effect->id;
      before = effect->effort.order;
      ++all;
    }
    EXPECT_FALSE(orders.empty());
  }
  const std::vector<const Effect*> others = effort_effects(EffortKind::none);
  EXPECT_EQ(all + others.size(), library().size());
  for (const Effect* effect : others) EXPECT_FALSE(effect->effort.tolerance) << effect->id;
}

TEST(EffortEffects, NameParametersThatTheyHave) {
  std::set<int> tolerances;
  for (const Effect& effect : library()) {
    const EffortColumns& e = effect.effort;
    if (e.kind == EffortKind::none) continue;
    ASSERT_FALSE(e.values.empty()) << effect.id;
    for (const std::size_t value : e.values)
      ASSERT_LT(value, effect.parameters.size()) << effect.id;
    for (const auto& held : e.held) EXPECT_EQ(held.size(), effect.parameters.size()) << effect.id;
    EXPECT_LT(e.constant.value_or(0), effect.parameters.size()) << effect.id;
    if (!e.tolerance) continue;
    EXPECT_TRUE(tolerances.insert(e.tolerance->order).second) << effect.id;
    EXPECT_NE(e.tolerance->deviation, nullptr) << effect.id;
  }
  const auto constant = [](const Effect& e) { return e.effort.constant.has_value(); };
  EXPECT_EQ(std::count_if(library().begin(), library().end(), constant), 1);
}

/// Effort of one joint at some instant when nothing acts there but the effect with these values.
double effort_of(const Effect& effect, const std::vector<double>& theta) {
  SimParams params = make_params(test::pendulum("actuator = \"passive\"\n"));
  params.joints.front() = JointParams{};
  effect.apply(params, 0, theta);
  return joint_effort(params.joints.front(), 0.7, 1.3, -2.1, 0.4, 0.2);
}

TEST(EffortEffects, AreLinearInTheirValues) {
  for (const EffortKind kind : {EffortKind::joint, EffortKind::ripple}) {
    for (const Effect* effect : effort_effects(kind)) {
      std::vector<double> theta =
          effect->effort.held.empty() ? effect->null() : effect->effort.held.front();
      double sum = 0.0;
      std::vector<double> all = theta;
      for (const std::size_t value : effect->effort.values) {
        std::vector<double> one = theta, twice = theta;
        one[value] = 0.1, twice[value] = 0.2, all[value] = 0.1;
        EXPECT_NE(effort_of(*effect, one), 0.0) << effect->id;
        EXPECT_NEAR(effort_of(*effect, twice), 2.0 * effort_of(*effect, one), 1e-12) << effect->id;
        sum += effort_of(*effect, one);
      }
      EXPECT_NEAR(effort_of(*effect, all), sum, 1e-12) << effect->id;
    }
  }
}

TEST(EffortEffects, OfDryFrictionHoldAgainstTheMotion) {
  for (const Effect* effect : effort_effects(EffortKind::joint)) {
    if (effect->effort.dry != DryFriction::adds) continue;
    std::vector<double> theta =
        effect->effort.held.empty() ? effect->null() : effect->effort.held.front();
    theta[effect->effort.values.front()] = 0.1;
    EXPECT_GT(effort_of(*effect, theta), 0.0) << effect->id << ": forwards it takes effort";
  }
}

TEST(WholeFigures, AreOneEffectEach) {
  std::set<std::string> names;
  for (int f = 1; f <= static_cast<int>(WholeFigure::push); ++f) {
    const auto figure = static_cast<WholeFigure>(f);
    EXPECT_EQ(effect_of(figure).whole, figure);
    EXPECT_TRUE(names.insert(name_of(figure)).second) << name_of(figure);
    EXPECT_FALSE(effect_of(figure).parameters.empty()) << name_of(figure);
    EXPECT_FALSE(effect_of(figure).regimes.empty()) << name_of(figure);
  }
  const auto has = [](const Effect& e) { return e.whole != WholeFigure::none; };
  EXPECT_EQ(std::count_if(library().begin(), library().end(), has),
            static_cast<std::ptrdiff_t>(names.size()));
  EXPECT_THROW(effect_of(WholeFigure::none), std::logic_error);
}

TEST(DriveFigures, AreOneEffectEachAndKeysOfTheModelWhereTheyArePlaced) {
  std::set<JointFigure> figures;
  for (const Effect& effect : library()) {
    if (!effect.drive) continue;
    EXPECT_TRUE(figures.insert(effect.drive->figure).second) << effect.id;
    EXPECT_EQ(effect_of(effect.drive->figure), &effect);
    // what the wholebody room keeps beside the keys of model.toml
    const JointFigure figure = effect.drive->figure;
    if (figure == JointFigure::load || figure == JointFigure::zero) {
      EXPECT_TRUE(effect.settings.empty()) << effect.id;
      continue;
    }
    if (!effect.drive->placed) continue;
    JointSettings settings;
    settings.actuator = Actuator::position_pd, settings.kp = 12.0;
    const JointSettings before = settings;
    const EffectParameter& p = effect.parameters.front();
    EXPECT_TRUE(effect.fold_into(settings, 0, p.null)) << effect.id;
    EXPECT_EQ(settings.kp, before.kp) << effect.id << " changes nothing at its null";
    EXPECT_TRUE(effect.fold_into(settings, 0, p.null + p.typical)) << effect.id;
    EXPECT_TRUE(settings.kp != before.kp || settings.viscous != before.viscous ||
                settings.coulomb != before.coulomb ||
                settings.command_delay_s != before.command_delay_s)
        << effect.id;
  }
  EXPECT_EQ(effect_of(JointFigure::rotor), nullptr) << "a standing robot hardly accelerates";
}

}  // namespace
}  // namespace sanso::diagnose
