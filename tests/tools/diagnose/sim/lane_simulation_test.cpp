// Windows in step: numbers in lanes are what they are alone, and so are motions, whatever their
// neighbours do.
#include "tools/diagnose/sim/lane_simulation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/small_world.h"
#include "tools/diagnose/sim/servo.h"
#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {
namespace {

using namespace test;
using Pair = portable::Pack<2>;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Pair pair(double a, double b) {
  const double x[2] = {a, b};
  Pair out;
  portable::load(x, out);
  return out;
}
/// Both lanes of f(pair) against f of each number.
template <class F>
void expect_lane_by_lane(double a, double b, const F& f) {
  double x[2];
  portable::store(f(pair(a, b)), x);
  EXPECT_EQ(x[0], f(a));
  EXPECT_EQ(x[1], f(b));
}

TEST(LaneMath, EveryOperationIsThatOfOneNumber) {
  for (const double a : {-2.5, -1e-300, 0.0, 0.3, 7.0, 1e5}) {
    for (const double b : {-3.0, 0.0, 0.1, 2.5, kInfinity}) {
      expect_lane_by_lane(a, b, [](auto x) { return portable::abs_of(x); });
      expect_lane_by_lane(a, b, [](auto x) {
        using T = decltype(x);
        return portable::clamped(x, T(-2.0), T(0.25));
      });
      expect_lane_by_lane(a, b, [](auto x) {
        using T = decltype(x);
        return portable::with_sign(T(3.0), x);
      });
      expect_lane_by_lane(a, b, [](auto x) { return portable::exp_of(-portable::abs_of(x)); });
      expect_lane_by_lane(a, b, [](auto x) { return portable::log1p_of(portable::abs_of(x)); });
      expect_lane_by_lane(a, b,
                          [](auto x) { return portable::power_of(portable::abs_of(x), 1.3); });
    }
    expect_lane_by_lane(a, -a, [](auto x) {
      return portable::ripple_at({0.2, -0.7, 3.0}, x) + portable::ripple_slope({0.5, 1, 2}, x);
    });
  }
}

TEST(LaneMath, ExponentialsAreThoseOfTheLibrary) {
  const auto near = [](double value, double expected) {
    EXPECT_NEAR(value, expected, 4e-15 * std::max(std::abs(expected), 1e-290)) << expected;
  };
  for (double x = -690.0; x < 690.0; x += 0.7371) near(portable::exp_of(x), std::exp(x));
  for (double x = -3.0; x < 3.0; x += 0.00917) near(portable::exp_of(x), std::exp(x));
  EXPECT_LT(portable::exp_of(-kInfinity), 1e-300);
  for (double x = 1e-12; x < 1e12; x *= 1.173) {
    near(portable::log1p_of(x), std::log1p(x));
    for (const double exponent : {0.5, 1.0, 1.37, 2.0}) {
      // as exact as the logarithm, times what the power is of it
      const double expected = std::pow(x, exponent);
      EXPECT_NEAR(portable::power_of(x, exponent), expected,
                  4e-15 * expected * (1.0 + std::abs(std::log(expected))));
    }
  }
  EXPECT_EQ(portable::log1p_of(0.0), 0.0);
  EXPECT_LT(portable::power_of(0.0, 0.5), 1e-100);
}

TEST(LaneMath, AnAnswerIsYesWhereAnyLaneSaysSo) {
  EXPECT_TRUE(portable::any(portable::less(pair(1, 2), pair(0, 3))));
  EXPECT_FALSE(portable::any(portable::less(pair(1, 2), pair(1, 2))));
  EXPECT_TRUE(portable::any(portable::no_more(pair(1, 2), pair(1, 1))));
  const auto first = portable::less(pair(0, 1), pair(1, 0));
  EXPECT_FALSE(portable::any(portable::both(first, portable::negated(first))));
  EXPECT_TRUE(portable::any(portable::either(first, portable::negated(first))));
  double x[2];
  portable::store(portable::choose(first, Pair(5.0), Pair(6.0)), x);
  EXPECT_EQ(x[0], 5.0);
  EXPECT_EQ(x[1], 6.0);
}

TEST(LaneMath, ARippleIsItsSineAndCosine) {
  const Ripple r{0.02, -0.05, 7.0};
  for (double x = -9.0; x < 9.0; x += 0.37) {
    EXPECT_NEAR(portable::ripple_at(r, x), 0.02 * std::sin(7 * x) - 0.05 * std::cos(7 * x), 1e-15);
    const double h = 1e-6;
    EXPECT_NEAR(portable::ripple_slope(r, x),
                (portable::ripple_at(r, x + h) - portable::ripple_at(r, x - h)) / (2 * h), 1e-8);
  }
}

/// An arm that follows its commands, and windows of all lengths at any rows.
struct World {
  World()
      : model(arm("actuator = \"position_pd\"\nkp = 20\nkd = 1\ncoulomb = 0.05\n")),
        params(make_params(model)),
        drive(make_test_drive(model, 2.0, 0.01,
                              [](int j, double t) { return 0.2 * std::sin(5 * t + j); })) {
    for (std::size_t k = 0; k < 13; ++k)
      windows.push_back({7 * k,
                         7 * k + (k * k) % 41,
                         {0.1, 0.02 * static_cast<double>(k), 0.01},
                         {0.0, 0.1, 0.0}});
  }
  std::vector<Prediction> run(const LaneUnit* unit, std::span<const Window> which) const {
    SimOptions options;
    options.unit = unit;
    return simulate(params, drive, which, options);
  }
  void expect_alone() const {
    const auto alone = run(&lane_units().back(), windows);
    for (const LaneUnit& unit : lane_units()) {
      if (!unit.runs_here()) continue;
      const auto together = run(&unit, windows);
      for (std::size_t w = 0; w < windows.size(); ++w) {
        EXPECT_EQ(alone[w].q, together[w].q) << unit.name << " window " << w;
        EXPECT_EQ(alone[w].tau, together[w].tau) << unit.name << " window " << w;
        EXPECT_EQ(alone[w].volt, together[w].volt) << unit.name << " window " << w;
      }
    }
  }
  ModelFolder model;
  SimParams params;
  Drive drive;
  std::vector<Window> windows;
};

TEST(LaneSimulation, WindowsOfAllLengthsAreWhatTheyAreAlone) { World().expect_alone(); }

TEST(LaneSimulation, DelayedReadingsAreWhatTheyAreAlone) {
  World world;
  world.params.joints[0].sensor_delay = 0.013;
  world.params.joints[2].command_delay = 0.004;
  world.expect_alone();
}

TEST(LaneSimulation, AMotionThatDivergesStaysWhereItWasAndHarmsNoNeighbour) {
  World world;
  const auto calm = world.run(nullptr, world.windows);
  world.windows[4].dq[1] = 3e4;  // beyond what counts as motion
  world.windows[4].last = world.windows[4].first + 30;
  const auto with = world.run(nullptr, world.windows);
  for (std::size_t w = 0; w < world.windows.size(); ++w) {
    if (w == 4) continue;
    EXPECT_EQ(calm[w].q, with[w].q) << w;
  }
  for (const double q : with[4].q) EXPECT_TRUE(std::isfinite(q));
  EXPECT_EQ(with[4].of(with[4].q, 1).front(), with[4].of(with[4].q, 1).back());
  world.expect_alone();
}

TEST(LaneSimulation, AWindowOfOneRowIsItsStart) {
  World world;
  for (Window& w : world.windows) w.last = w.first;
  for (const Prediction& p : world.run(nullptr, world.windows)) EXPECT_DOUBLE_EQ(p.q[0], 0.1);
  world.expect_alone();
}

TEST(LaneSimulation, TheLastWayRunsEverywhere) {
  EXPECT_TRUE(lane_units().back().runs_here());
  EXPECT_TRUE(lane_units()[lane_units().size() - 2].runs_here());
}

}  // namespace
}  // namespace sanso::diagnose
