// The planner reads verdicts by their names: each is an effect of the diagnosis's library, at the
// places and with the parameters that the library gives it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "host/learn/model/named_figures.h"
#include "tools/diagnose/effects/effect.h"

namespace sanso::learn {
namespace {

diagnose::Scope scope_of(FigurePlace place) {
  switch (place) {
    case FigurePlace::joint:
      return diagnose::Scope::joint;
    case FigurePlace::link:
      return diagnose::Scope::link;
    case FigurePlace::ground:
      return diagnose::Scope::robot;
  }
  return diagnose::Scope::robot;
}

/// The parameter of an effect; nullptr: it has none of this name.
const diagnose::EffectParameter* parameter_of(const diagnose::Effect& effect,
                                              std::string_view name) {
  const auto& all = effect.parameters;
  const auto at =
      std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == name; });
  return at == all.end() ? nullptr : &*at;
}

std::vector<std::string> somewhere(FigurePlace place) {
  if (place == FigurePlace::ground) return {};
  return {place == FigurePlace::joint ? "l_knee" : "body_link"};
}

bool same(const model::ModelParameters& a, const model::ModelParameters& b) {
  return std::memcmp(&a, &b, sizeof(a)) == 0;
}

TEST(KnownFigures, AreEffectsOfTheLibraryWithItsPlacesAndParameters) {
  for (const KnownFigure& known : known_figures()) {
    const diagnose::Effect* effect = diagnose::find_effect(known.effect);
    ASSERT_NE(effect, nullptr) << known.effect;
    EXPECT_EQ(effect->scope, scope_of(known.place)) << known.effect;
    for (const std::string_view name : known.parameters)
      EXPECT_NE(parameter_of(*effect, name), nullptr) << known.effect << "." << name;
  }
}

TEST(KnownFigures, ChangeByEveryParameterThatTheyReadAndByNoneAtItsNull) {
  const model::ModelParameters nominal = model::nominal_parameters();
  for (const KnownFigure& known : known_figures()) {
    const diagnose::Effect& effect = *diagnose::find_effect(known.effect);
    NamedFigure figure{std::string(known.effect), somewhere(known.place), {}};
    for (const std::string_view name : known.parameters)
      figure.parameters[std::string(name)] = parameter_of(effect, name)->null;
    // the ground's null is a number of its own, no change of the planner's
    if (known.place == FigurePlace::ground) figure.parameters.clear();
    model::ModelParameters theta = nominal;
    EXPECT_EQ(put_figure(figure, theta), "") << known.effect;
    EXPECT_TRUE(same(theta, nominal)) << known.effect;
    for (const std::string_view name : known.parameters) {
      NamedFigure changed = figure;
      // where a payload is says nothing without its mass
      const bool arm = effect.whole == diagnose::WholeFigure::payload && name != "mass";
      if (arm) changed.parameters["mass"] = 0.3;
      model::ModelParameters before = nominal, after = nominal;
      EXPECT_EQ(put_figure(changed, before), "") << known.effect;
      changed.parameters[std::string(name)] += 0.5 * parameter_of(effect, name)->high;
      EXPECT_EQ(put_figure(changed, after), "") << known.effect;
      EXPECT_FALSE(same(after, before)) << known.effect << "." << name;
    }
  }
}

TEST(KnownFigures, KilogramsAreWhatTheLibraryCallsAHeavierLinkAndAPayload) {
  for (const KnownFigure& known : known_figures()) {
    const diagnose::WholeFigure whole = diagnose::find_effect(known.effect)->whole;
    EXPECT_EQ(known.kilograms,
              whole == diagnose::WholeFigure::mass_share || whole == diagnose::WholeFigure::payload)
        << known.effect;
  }
}

TEST(KnownFigures, AnUnknownNameHasNone) {
  EXPECT_EQ(known_figure("imu_bias"), nullptr);
  EXPECT_EQ(known_figure(""), nullptr);
}

}  // namespace
}  // namespace sanso::learn
