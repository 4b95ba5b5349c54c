// Lost commands are found at the rows at which they were lost, and where none were lost none are
// found.
#include "tools/diagnose/explain/losses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/lossy_world.h"

namespace sanso::diagnose {
namespace {

using test::kNoise, test::record;

/// What is found when the nominal model is all that was fitted. `lost`, `unread`: of every
/// recording, rows whose commands did not arrive, and in which nothing was read.
std::optional<LossScore> found(const std::vector<EffectEntry>& effects,
                               const std::vector<std::size_t>& lost, double noise = kNoise,
                               const std::vector<std::size_t>& unread = {},
                               test::Goal goal = test::swing) {
  std::vector<recording::Recording> recordings;
  recordings.reserve(3);
  for (int i = 0; i < 3; ++i) {
    recordings.push_back(record(effects, i, lost, noise, goal));
    for (const char* name : {"q:a", "pwm:a"}) {
      std::vector<double> x(recordings[i].find(name).begin(), recordings[i].find(name).end());
      for (const std::size_t row : unread) x[row] = NAN;
      recordings[i].set(name, x);
    }
  }
  const test::SmallComparison compared(test::pendulum(test::kServo), recordings,
                                       {{"q:a", 0.0, noise, {}}, {"pwm:a", 0.0, 1e-3, {}}},
                                       {"timing_jitter", "packet_loss"});
  const Surroundings around = make_surroundings(compared.problem, compared.library, Model{});
  std::optional<LossScore> out = find_losses(around, fit(around, Model{}, 3));
  if (out) {
    EXPECT_EQ(compared.name_of(out->candidate), "packet_loss");
  }
  return out;
}

TEST(Losses, AreFoundAtTheirRows) {
  const std::vector<std::size_t> lost{130, 131, 222, 347, 510, 511, 512, 668, 815, 905};
  const std::optional<LossScore> said = found({}, lost);
  ASSERT_TRUE(said);
  const LossScore& score = *said;
  std::size_t right = 0;
  for (const LostCommand& l : score.lost)
    right += std::count(lost.begin(), lost.end(), l.row) > 0 ? 1 : 0;
  EXPECT_GE(right, 24U);  // of 30; where the goal turns a loss changes nothing
  EXPECT_LE(score.lost.size(), right + 2);
  EXPECT_TRUE(score.blind);
  EXPECT_LT(score.misfit, 2.0);
  EXPECT_LT(score.left_share, ChanceSettings{}.loss_left);
  EXPECT_LT(score.mirrored, 0.5 * ChanceSettings{}.loss_mirrored);
  EXPECT_NEAR(score.left, 1.0, 0.2);
  EXPECT_LT(score.low, 0.01);
  EXPECT_GT(score.high, 0.01);
}

// Each shows at a hundred times the noise: what is 4 % off in the robot is then far more than noise
// in what a loss changes, and a loss all the same.
TEST(Losses, AreWholeInARobotWithinItsTolerances) {
  const std::vector<std::size_t> lost{130, 131, 222, 347, 510, 511, 512, 668, 815, 905};
  const std::optional<LossScore> said =
      found({{"servo_p_gain", {"a"}, {{"gain", 0.96}}, 0}}, lost, kNoise / 10.0);
  ASSERT_TRUE(said);
  EXPECT_FALSE(said->unseen);
  EXPECT_LT(said->misfit, 2.0);
}

// Two bursts in thirty seconds, in a robot whose every reversal is a little off: most of the shots
// that are farthest from noise hold no loss, most of what stands beyond noise does.
TEST(Losses, RareBurstsStandOutFromManySmallErrors) {
  std::vector<std::size_t> lost;
  for (const std::size_t from : {205U, 710U})
    for (std::size_t k = 0; k < 8; ++k) lost.push_back(from + k);
  const std::optional<LossScore> said =
      found({{"coulomb_friction", {"a"}, {{"coulomb", 0.002}}, 0}}, lost, kNoise);
  ASSERT_TRUE(said);
  std::size_t right = 0;
  for (const LostCommand& l : said->lost)
    right += std::count(lost.begin(), lost.end(), l.row) > 0 ? 1 : 0;
  EXPECT_GE(right, 36U);  // of 48
  EXPECT_FALSE(said->unseen);
  EXPECT_LT(said->misfit, 2.0);
  EXPECT_LT(said->low, 0.016);
  EXPECT_GT(said->high, 0.016);
}

/// A quarter of all rows, in bursts.
std::vector<std::size_t> quarter() {
  std::vector<std::size_t> out;
  Random random(7);
  bool lost = false;
  for (std::size_t row = 5; row < 990; ++row) {
    lost = random.uniform() < (lost ? 0.7 : 0.1);
    if (lost) out.push_back(row);
  }
  return out;
}

TEST(Losses, OfCyclesThatWereNotReadEitherAreCounted) {
  const std::vector<std::size_t> lost = quarter();
  const std::optional<LossScore> said = found({}, lost, kNoise, lost);
  ASSERT_TRUE(said);
  EXPECT_FALSE(said->unseen);
  EXPECT_LT(said->misfit, 2.0);
  EXPECT_LT(said->left_share, ChanceSettings{}.loss_left);
  EXPECT_NEAR(said->size, static_cast<double>(lost.size()) / 1000.0, 0.02);
  EXPECT_LT(said->high - said->low, 0.1);
}

double stairs(int index, double t) {
  return 0.5 * std::sin(1.9 * (index + 1) * std::floor(4.0 * t));
}

// Where the goal rests a loss changes nothing, and its cycle is lost all the same.
TEST(Losses, OfCyclesAreCountedWhereTheGoalRestsToo) {
  const std::vector<std::size_t> lost = quarter();
  const std::optional<LossScore> said = found({}, lost, kNoise, lost, stairs);
  ASSERT_TRUE(said);
  EXPECT_NEAR(said->size, static_cast<double>(lost.size()) / 1000.0, 0.02);
}

TEST(Losses, OfReadingsAloneAreNone) { EXPECT_FALSE(found({}, {}, kNoise, quarter())); }

TEST(Losses, AreWhatOneNameOfChanceMakes) {
  const test::SmallComparison compared(
      test::pendulum(test::kServo), {record({}, 0, {})}, {{"q:a", 0.0, kNoise, {}}},
      {"timing_jitter", "packet_loss", "sample_hold", "command_delay"});
  const SimParams& nominal = compared.problem->sources.front().nominal;
  std::size_t losing = 0;
  for (const Candidate& c : compared.library.candidates) {
    EXPECT_EQ(loses_commands(c, nominal), c.effect == "packet_loss") << c.title();
    losing += loses_commands(c, nominal) ? 1 : 0;
  }
  EXPECT_GT(losing, 0U);
}

TEST(Losses, NoneInACleanWorld) { EXPECT_FALSE(found({}, {})); }

// With a command every 10 ms a smooth error can be drawn by losses, and as well by commands that go
// too far.
TEST(Losses, OfASmoothErrorTheirMirrorMendsAsMuch) {
  int said = 0;
  for (const double size : {0.01, 0.03, 0.1}) {
    const std::optional<LossScore> score =
        found({{"coulomb_friction", {"a"}, {{"coulomb", size}}, 0},
               {"cogging", {"a"}, {{"sine", size}, {"cosine", size}, {"order", 7.0}}, 0}},
              {}, kNoise / 10.0);
    if (!score) continue;
    ++said;
    EXPECT_GT(score->mirrored, 2.0 * ChanceSettings{}.loss_mirrored) << size;
  }
  EXPECT_GT(said, 0);
}

TEST(Losses, AnotherErrorIsNotMadeOfWholeLosses) {
  const std::optional<LossScore> said =
      found({{"command_delay", {"a"}, {{"delay", 0.004}}, 0}}, {});
  if (!said) return;
  const LossScore& score = *said;
  const bool more_is_left = score.left > 1.42 && score.left_share > ChanceSettings{}.loss_left;
  EXPECT_TRUE(score.misfit > 2.0 || more_is_left || !score.blind)
      << score.lost.size() << " found, misfit " << score.misfit << ", left " << score.left;
}

}  // namespace
}  // namespace sanso::diagnose
