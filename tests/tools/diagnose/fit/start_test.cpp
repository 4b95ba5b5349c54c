// Where fits begin: what no derivative leads to.
#include "tools/diagnose/fit/start.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/small_comparison.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kServo =
    "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\ncoulomb = 0.02";

/// Steps of a goal in a servo with `effects`, told from the nominal one.
test::SmallComparison steps_of(const std::vector<EffectEntry>& effects,
                               const std::vector<std::string>& library) {
  const ModelFolder world = test::hiding(test::pendulum(kServo), effects);
  std::vector<recording::Recording> recordings;
  for (int i = 0; i < 2; ++i) {
    const Drive drive = test::make_test_drive(world, 8.0, 0.01, [i](int, double t) {
      const int step = static_cast<int>(t / 0.8) + i;
      return 0.3 * ((7 * step) % 5 - 2);
    });
    recordings.push_back(
        test::record(world, drive, {.file = "made_" + std::to_string(i) + ".csv"}));
  }
  return test::SmallComparison(test::pendulum(kServo), recordings, {{"q:a", 0.0, 3e-4, {}}},
                               library);
}

// A profile that limits the speed alone changes the same stretches as one that limits the
// acceleration, and the screening may prefer either: whichever probe it names, the fit gets there.
TEST(Start, EveryChoiceOfLimitsIsTried) {
  constexpr double kSpeed = 3.0;
  const test::SmallComparison compared =
      steps_of({{"servo_profile", {"a"}, {{"speed", kSpeed}, {"acceleration", kOff}}, 0}},
               {"servo_profile"});
  const Surroundings around = make_surroundings(compared.problem, compared.library, Model{});
  const std::size_t profile = compared.of("servo_profile");
  const std::size_t probes = compared.library[profile].probes.size();
  for (std::size_t probe = 0; probe < probes; ++probe) {
    ProbeScore named;
    named.candidate = profile, named.probe = probe, named.amount = 1.0;
    const FitResult found = fit(around, best_start(around, Model{}, profile, &named), 12);
    EXPECT_NEAR(found.model.effects.back().theta[0], kSpeed, 0.05) << "probe " << probe;
  }
}

// A servo that limits both is neither one's: from the better of the two no derivative leads on.
TEST(Start, TwoLimitsAreFoundTogether) {
  constexpr double kSpeed = 2.0, kAcceleration = 12.0;
  const test::SmallComparison compared =
      steps_of({{"servo_profile", {"a"}, {{"speed", kSpeed}, {"acceleration", kAcceleration}}, 0}},
               {"servo_profile"});
  const Surroundings around = make_surroundings(compared.problem, compared.library, Model{});
  const std::size_t profile = compared.of("servo_profile");
  const FitResult found = fit(around, best_start(around, Model{}, profile, nullptr), 12);
  EXPECT_NEAR(found.model.effects.back().theta[0], kSpeed, 0.05);
  EXPECT_NEAR(found.model.effects.back().theta[1], kAcceleration, 0.5);
}

// A hard stop is met just before the end of what the joint did: from the soft one of the probes,
// which is met much earlier, no derivative leads there.
TEST(Start, AHardStopIsFoundJustBeforeTheEnd) {
  constexpr double kStiffness = 150.0, kPosition = 0.57;
  const test::SmallComparison compared =
      steps_of({{"joint_stop",
                 {"a"},
                 {{"stiffness", kStiffness}, {"position", kPosition}, {"side", 1.0}, {"loss", 0.1}},
                 0}},
               {"joint_stop"});
  const Surroundings around = make_surroundings(compared.problem, compared.library, Model{});
  const std::size_t stop = compared.of("joint_stop");
  const std::vector<std::vector<double>>& probes = compared.library[stop].probes;
  for (std::size_t probe = 0; probe < probes.size(); probe += 4) {  // one of each depth
    ProbeScore named;
    named.candidate = stop, named.probe = probe, named.amount = 1.0;
    const FitResult found = fit(around, best_start(around, Model{}, stop, &named), 12);
    const std::vector<double>& is = found.model.effects.back().theta;
    EXPECT_NEAR(is[0], kStiffness, 0.2 * kStiffness) << "probe " << probe;
    EXPECT_NEAR(is[1], kPosition, 0.005) << "probe " << probe;
  }
}

// Effects of sizes alone start where the named probe says, as ever.
TEST(Start, OneChoiceIsTheNamedProbe) {
  const test::SmallComparison compared =
      steps_of({{"coulomb_friction", {"a"}, {{"coulomb", 0.1}}, 0}}, {"coulomb_friction"});
  const Surroundings around = make_surroundings(compared.problem, compared.library, Model{});
  const std::size_t dry = compared.of("coulomb_friction");
  const Model start = best_start(around, Model{}, dry, nullptr);
  EXPECT_GT(start.effects.back().theta[0], 0.03);
  EXPECT_LT(start.effects.back().theta[0], 0.3);
}

}  // namespace
}  // namespace sanso::diagnose
