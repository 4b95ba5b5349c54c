// Since when a load hangs on: to a row where the motion tells, between two of the search's shots
// too, and no nearer than the data say.
#include "tools/diagnose/explain/instants.h"

#include <gtest/gtest.h>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/explain/whole_time.h"

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

}  // namespace
}  // namespace sanso::diagnose
