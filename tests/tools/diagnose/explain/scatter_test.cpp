// Effects that are chance are recognised by the scatter that they make, and by nothing else.
#include "tools/diagnose/explain/scatter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_comparison.h"
#include "tools/diagnose/explain/polling.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kServo =
    "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\ncoulomb = 0.02";
constexpr double kQuantum = 2 * 3.14159265358979 / 4096;

/// 10 s at 100 Hz of a servo in a world with `effects`, chance drawn, readings quantised.
recording::Recording record(const std::vector<EffectEntry>& effects, int index, bool duty) {
  const ModelFolder world = test::hiding(test::pendulum(kServo), effects);
  const Drive drive = test::make_test_drive(world, 10.0, 0.01, [index](int, double t) {
    return 0.7 * std::sin((1.3 + 0.4 * index) * t) + 0.3 * std::sin((4.1 + 0.7 * index) * t);
  });
  recording::Recording r = test::record(world, drive,
                                        {.file = "made_" + std::to_string(index) + ".csv",
                                         .duty = duty,
                                         .chance_seed = 91 + static_cast<std::uint64_t>(index)});
  Random random(17, static_cast<std::uint64_t>(index));
  std::vector<double> q(r.find("q:a").begin(), r.find("q:a").end());
  for (double& x : q) x = kQuantum * std::round((x + 0.3 * kQuantum * random.normal()) / kQuantum);
  r.set("q:a", q);
  if (!duty) return r;
  std::vector<double> pwm(r.find("pwm:a").begin(), r.find("pwm:a").end());
  for (double& x : pwm) x = std::round(885 * x) / 885;
  r.set("pwm:a", pwm);
  return r;
}

/// What is said about three recordings of the world, best first, when the nominal model is all that
/// was fitted.
std::vector<ScatterScore> judged(const std::vector<EffectEntry>& effects, bool duty,
                                 Library& library) {
  const double sigma = kQuantum * std::sqrt(0.09 + 1.0 / 12.0);
  const test::SmallComparison compared(
      test::pendulum(kServo),
      {record(effects, 0, duty), record(effects, 1, duty), record(effects, 2, duty)},
      {{"q:a", kQuantum, sigma, {}}, {"pwm:a", 1.0 / 885, 0.3 / 885, {}}},
      {"timing_jitter", "packet_loss"});
  library = compared.library;
  const Surroundings around = make_surroundings(compared.problem, library, Model{});
  return judge_scatter(around, fit(around, Model{}, 3), 10.0, Random(1));
}

const std::string& name_of(const Library& library, const ScatterScore& s) {
  return library[s.candidate].effect;
}

/// A tolerated wait of commands scatters a joint that moves, as far as the delay may be a wait.
TEST(Scatter, OfPollingGrowsWithTheDelayUpToTheLongestWait) {
  const auto scatter = [](const std::string& delay_s) {
    const ModelFolder model =
        test::pendulum(std::string(kServo) + "\ncommand_delay_s = " + delay_s + "\n");
    const test::SmallComparison c(model, {record({}, 0, false)}, {{"q:a", kQuantum, 1e-4, {}}},
                                  {"timing_jitter"});
    Selection found;
    found.around = make_surroundings(c.problem, c.library, Model{});
    found.final = fit(*found.around, Model{}, 0);
    return scatter_of_polling(found, 1).sum();
  };
  EXPECT_LT(scatter("0.0"), 1e-9) << "rounding of a variance";
  const double one = scatter("0.001"), two = scatter("0.002");
  EXPECT_GT(one, 0.0);
  EXPECT_NEAR(two / one, 4.0, 0.4) << "a variance: the same draws, twice as far";
  EXPECT_NEAR(scatter("0.009") / scatter("0.004"), 1.0, 0.2) << "longer delays are ways";
}

TEST(Scatter, QuantisedReadingsOfACleanWorldAreNoChance) {
  Library library;
  const std::vector<ScatterScore> scores = judged({}, false, library);
  ASSERT_EQ(scores.size(), 2U);
  EXPECT_GT(scores.front().p_family, 0.01) << name_of(library, scores.front());
}

TEST(Scatter, JitterIsNamedAndMeasured) {
  Library library;
  const std::vector<ScatterScore> scores =
      judged({{"timing_jitter", {"a"}, {{"jitter", 0.003}}, 0}}, false, library);
  ASSERT_EQ(scores.size(), 2U);
  EXPECT_EQ(name_of(library, scores.front()), "timing_jitter");
  EXPECT_LT(scores.front().p_family, 0.01);
  EXPECT_NEAR(scores.front().size, 0.003, 0.0006);
  EXPECT_LT(scores.front().low, 0.003);
  EXPECT_GT(scores.front().high, 0.003);
  // shots begin on readings that are 10 times worse than the encoder
  EXPECT_NEAR(scores.front().left, 1.0, 0.3);
}

TEST(Scatter, MotionIsSmoothedByHowWellReadingsAreKnown) {
  const NoiseLevel level{"q:a", kQuantum, kQuantum * std::sqrt(0.09 + 1.0 / 12.0), {}};
  const std::vector<recording::Recording> made{
      record({{"timing_jitter", {"a"}, {{"jitter", 0.003}}, 0}}, 0, false)};
  const std::vector<recording::Recording> exact{record({}, 0, false)};
  const Problem made_of =
      make_problem(make_sources(test::pendulum(kServo), made, {level}, Settings{}), {level},
                   ProblemOptions{}, Settings{});
  const Source truth = make_sources(test::pendulum(kServo), exact, {level}, Settings{}).front();
  const auto error = [&](const Problem& problem) {
    double sum = 0.0;
    for (std::size_t k = 0; k < truth.motion.q[0].size(); ++k)
      sum += std::pow(problem->sources[0].motion.q[0][k] - truth.motion.q[0][k], 2.0);
    return sum;
  };
  const double before = error(made_of);
  EXPECT_EQ(error(resmoothed(made_of, {0.0})), before);
  const Problem known = resmoothed(made_of, {0.003});
  EXPECT_LT(error(known), 0.5 * before);
  EXPECT_EQ(error(made_of), before) << "what it was made of stays";
  const Shot& shot = known->shots.back();
  EXPECT_EQ(shot.window.q[0], known->sources[0].motion.q[0][shot.window.first]);
}

TEST(Scatter, LostCommandsAreNamedAndMeasured) {
  Library library;
  const std::vector<ScatterScore> scores =
      judged({{"packet_loss", {"a"}, {{"loss", 0.2}}, 0}}, true, library);
  ASSERT_EQ(scores.size(), 2U);
  EXPECT_EQ(name_of(library, scores.front()), "packet_loss");
  EXPECT_LT(scores.front().p_family, 0.01);
  EXPECT_NEAR(scores.front().size, 0.2, 0.1);
}

TEST(Scatter, TheRoughPartForgetsStraightLines) {
  Comparison comparison;
  comparison.channels.resize(1);
  comparison.shots.resize(1);
  comparison.shots[0].rows = 6;
  comparison.size = 6;
  Eigen::VectorXd x(6);
  x << 0, 1, 2, 3, 5, 5;
  const Eigen::VectorXd rough = rough_part(comparison, x);
  EXPECT_EQ(rough.head(3).norm(), 0.0);
  EXPECT_DOUBLE_EQ(rough[3], -0.5);
  EXPECT_DOUBLE_EQ(rough[4], 1.0);
  EXPECT_EQ(rough[5], 0.0);
}

}  // namespace
}  // namespace sanso::diagnose
