// Since when a load hangs on: to a row where the motion tells, between two of the search's shots
// too, and no nearer than the data say.
#include "tools/diagnose/explain/instants.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/explain/whole_time.h"
#include "tools/diagnose/fit/start.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr std::size_t kFrom = 4;  // of the payload's parameters
const std::vector<double> kLoad{0.15, 0.0, 0.0, -0.12, 0.0};

/// Two recordings of 8 s in which a load hangs on from `from` on.
struct Loaded {
  explicit Loaded(double from)
      : model(pendulum(kNoisyServo)),
        sources(make_sources(
            model,
            recordings_of(
                hiding(model, {hidden("payload", "arm",
                                      {{"mass", kLoad[0]}, {"z", kLoad[3]}, {"from", from}})}),
                2, 8.0, 23),
            noise_of(model), Settings{})),
        whole(sources, noise_of(model), ProblemOptions{}, Settings{}),
        problem(make_problem(sources, noise_of(model), ProblemOptions{}, Settings{})) {
    library.candidates = place_library(*problem, {"payload"}).candidates;
    library.nuisances = make_nuisances(*problem);
  }
  /// The load, thought to begin there.
  Model thought(double from) const {
    Model m;
    m.nuisance.assign(library.nuisances.size(), 0.0);
    m.effects.push_back({0, kLoad});
    m.effects[0].theta[kFrom] = from;
    return m;
  }
  ModelFolder model;
  std::vector<Source> sources;
  WholeTime whole;
  Problem problem;
  Library library;
};

TEST(BestInstant, IsFoundFromAnywhere) {
  const Loaded world(5.31);
  for (const double thought : {0.0, 2.0, 5.0, 7.5}) {
    const Instant best =
        best_instant(world.whole.problem(), world.library, world.thought(thought), 0, kFrom);
    EXPECT_NEAR(best.at, 5.31, 0.05) << thought;
    EXPECT_LE(best.low, 5.31) << thought;
    EXPECT_GE(best.high, 5.31) << thought;
    EXPECT_LT(best.high - best.low, 0.2) << thought;
  }
}

TEST(BestInstant, OfALoadThatWasAlwaysThereIsTheBeginning) {
  const Loaded world(0.0);
  const Instant best =
      best_instant(world.whole.problem(), world.library, world.thought(3.0), 0, kFrom);
  EXPECT_LT(best.at, 0.1);
  EXPECT_EQ(best.low, 0.0);
}

TEST(BestInstant, OfALoadThatIsNoneIsNotKnown) {
  const Loaded world(5.31);
  Model none = world.thought(3.0);
  none.effects[0].theta[0] = 1e-9;
  const Instant best = best_instant(world.whole.problem(), world.library, none, 0, kFrom);
  EXPECT_LT(best.low, 0.1) << "any instant leaves the same";
  EXPECT_GT(best.high, 7.0);
}

TEST(PlaceInstants, PutsTheSearchToTheInstantThatAllOfTheTimeShows) {
  const Loaded world(5.31);
  SelectOptions options;
  options.whole = &world.whole;
  const Selection found = select(world.problem, world.library, options);
  ASSERT_EQ(found.accepted.size(), 1U);
  EXPECT_NEAR(found.final.model.effects[0].theta[kFrom], 5.31, 0.05);
  ASSERT_TRUE(found.accepted[0].began);
  EXPECT_LE(found.accepted[0].began->first, 5.31);
  EXPECT_GE(found.accepted[0].began->second, 5.31);
}

/// Four recordings of 8 s with a push of 2 N for 0.12 s, and a fit that has it.
struct Pushed {
  Pushed() {
    ProblemOptions options;
    options.instants = {kPush[kStart]};
    options.struck = {0};
    const ModelFolder world =
        hiding(model, {hidden("external_push", "arm",
                              {{"x", kPush[0]}, {"from", kPush[3]}, {"duration", kPush[4]}})});
    problem = make_problem(
        make_sources(model, recordings_of(world, 4, 8.0, 29), noise_of(model), Settings{}),
        noise_of(model), options, Settings{});
    library.candidates = place_library(*problem, {"external_push"}).candidates;
    library.nuisances = make_nuisances(*problem);
    around.emplace(make_surroundings(problem, library, thought(0.0)));
    found = fit(*around, thought(0.0), 10);
  }
  Model thought(double longer) const {
    Model m;
    m.nuisance.assign(library.nuisances.size(), 0.0);
    m.effects.push_back({0, kPush});
    m.effects[0].theta[kDuration] += longer;
    return m;
  }

  static constexpr int kStart = 3, kDuration = 4;
  const ModelFolder model = pendulum(kNoisyServo);
  const std::vector<double> kPush{2.0, 0.0, 0.0, 4.15, 0.12};
  Problem problem;
  Library library;
  std::optional<Surroundings> around;
  FitResult found;
};

TEST(SpreadOfInstants, SaysWhatTheErrorRisesByWhereAPushLastsLonger) {
  const Pushed world;
  const Eigen::MatrixXd spread = spread_of_instants(*world.around, world.found, 1.0);
  // the beginning stands still below: variance of the duration given it
  const Eigen::Matrix2d together = spread.block<2, 2>(Pushed::kStart, Pushed::kStart);
  const double typical = world.library.candidates[0].parameters[Pushed::kDuration].typical;
  const double deviation = typical / std::sqrt(together.inverse()(1, 1));
  EXPECT_GT(deviation, 1e-4);
  EXPECT_LT(deviation, 0.03);
  const double longer = 0.02;
  double rise = -world.found.objective;
  for (const double sign : {-1.0, 1.0})
    rise += 0.5 * fit(*world.around, world.thought(sign * longer), 10).objective;
  EXPECT_NEAR(std::sqrt(rise), longer / deviation, 0.35 * longer / deviation);
}

TEST(SpreadOfInstants, AStrongerPushMayBeAShorterOne) {
  const Pushed world;
  const Eigen::MatrixXd spread = spread_of_instants(*world.around, world.found, 1.0);
  EXPECT_LT(spread(0, Pushed::kDuration),
            -0.9 * std::sqrt(spread(0, 0) * spread(Pushed::kDuration, Pushed::kDuration)));
  const Eigen::MatrixXd crude = spread_of_instants(*world.around, world.found, 4.0);
  EXPECT_NEAR(crude(0, 0), 4.0 * spread(0, 0), 0.1 * crude(0, 0));
}

TEST(SpreadOfInstants, OfWhatNoShotShowsIsNothing) {
  Pushed world;
  world.found.model.effects[0].theta[Pushed::kStart] = 100.0;  // after the last of them
  EXPECT_TRUE(spread_of_instants(*world.around, world.found, 1.0).isZero());
}

/// Half a shot early and twice as long: its edges are found where they show, and what else the
/// model has stays where all shots put it.
TEST(Event, IsSoughtInTheShotsThatCanShowIt) {
  Pushed pushed;
  Candidate early = pushed.library[0];
  early.probes = {{2.0, 0.0, 0.0, pushed.kPush[Pushed::kStart] - 0.2, 0.25}};
  pushed.library.candidates.push_back(early);
  const std::size_t candidate = pushed.library.candidates.size() - 1;
  Model base;
  base.effects.push_back({0, {0.3, 0.0, 0.0, 1.0, 0.1}});
  const Model start = best_start(*pushed.around, base, candidate, nullptr);
  ASSERT_EQ(start.effects.size(), 2U);
  EXPECT_EQ(start.effects[0].theta, base.effects[0].theta);
  const std::vector<double>& theta = start.effects[1].theta;
  EXPECT_NEAR(theta[Pushed::kStart], pushed.kPush[Pushed::kStart], 0.03);
  EXPECT_NEAR(theta[Pushed::kStart] + theta[Pushed::kDuration],
              pushed.kPush[Pushed::kStart] + pushed.kPush[Pushed::kDuration], 0.03);
}

}  // namespace
}  // namespace sanso::diagnose
