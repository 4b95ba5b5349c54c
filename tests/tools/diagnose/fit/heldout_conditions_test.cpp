// What conditions that are left out are asked: whether an effect holds there, not what it is.
#include <gtest/gtest.h>

#include <memory>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kHidden = 0.12;  // N m s/rad

/// Three recordings of a damped pendulum, the first under a condition of its own and the only one
/// in which it moves.
SmallComparison moving_in_one_condition(double only_there) {
  const ModelFolder model = pendulum(kNoisyServo);
  const ModelFolder world =
      hiding(model, {hidden("viscous_friction", "a", {{"viscous", kHidden}})});
  std::vector<recording::Recording> recordings;
  for (int k = 0; k < 3; ++k) {
    const Drive drive = make_test_drive(
        world, 4.0, 0.01, [k](int j, double t) { return k == 0 ? wave(k, j, t) : 0.1; });
    Recorded how;
    how.file = "rec_" + std::to_string(k) + ".csv";
    how.noise_seed = 70 + static_cast<std::uint64_t>(k);
    recordings.push_back(record(world, drive, how));
  }
  SmallComparison c(model, recordings, noise_of(model), {"viscous_friction"});
  c.library.nuisances.clear();
  Comparison changed = *c.problem;
  changed.settings.decisions.only_there = only_there;
  for (Shot& shot : changed.shots) shot.condition = shot.source == 0 ? 0 : 1;
  changed.conditions = 2;
  c.problem.comparison = std::make_shared<const Comparison>(std::move(changed));
  return c;
}

// Recordings in which nothing moves do not tell a friction: left to them it would go anywhere, and
// the recording in which it shows would speak against it.
TEST(HeldOutConditions, OneThatAloneTellsANumberKeepsIt) {
  const auto lost = [](double only_there) {
    const SmallComparison c = moving_in_one_condition(only_there);
    const Model start = with(c, c.of("viscous_friction"), {kHidden});
    const Surroundings around = make_surroundings(c.problem, c.library, start);
    const FitResult f = fit(around, start, 12);
    return heldout_energy(around, f, true).sum() /
           around.bounded(around.starts.energy_by_shot(f.r)).sum();
  };
  EXPECT_LT(lost(10.0), 1.05);
  EXPECT_GT(lost(1e12), 1.2);
}

}  // namespace
}  // namespace sanso::diagnose
