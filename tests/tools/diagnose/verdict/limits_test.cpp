// What data could not show, by the size of signatures; a model that was found, as a model folder.
#include "tools/diagnose/verdict/limits.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/verdict/patched_model.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A library of two effects at two joints, and probes of them with these sizes in noise levels.
struct Screened {
  explicit Screened(const std::vector<double>& signatures) {
    for (std::size_t i = 0; i < signatures.size(); ++i) {
      Candidate c;
      c.effect = i < 2 ? "backlash" : "air_drag";
      c.where = {i % 2 == 0 ? "hip" : "knee"};
      CandidateParameter p;
      p.name = "width", p.unit = "rad", p.high = 1.0;
      c.parameters = {p};
      c.probes = {{0.1}};
      library.candidates.push_back(c);
      ProbeScore probe;
      probe.candidate = i;
      probe.signature = signatures[i];
      screening.probes.push_back(probe);
    }
    screening.critical = 4.0;
  }
  Library library;
  Screening screening;
};

TEST(TooQuiet, IsAnEffectWhoseLargestProbeMakesLessThanThreeNoiseLevels) {
  const Screened s({0.5, 8.0, 2.9, 0.1});
  const std::vector<Untestable> quiet = too_quiet(s.library, s.screening, DecisionSettings{});
  ASSERT_EQ(quiet.size(), 1u);
  EXPECT_EQ(quiet[0].effect, "air_drag");
  EXPECT_NE(quiet[0].because.find("2.9 noise levels"), std::string::npos) << quiet[0].because;
}

TEST(SmallestSizes, HalveWhereTheSignatureDoubles) {
  const Screened s({10.0, 20.0});
  const std::vector<Detectable> sizes = smallest_sizes(s.library, s.screening);
  ASSERT_EQ(sizes.size(), 2u);
  EXPECT_NEAR(sizes[0].size, 0.1 * (4.0 + 0.84) / 10.0, 1e-12);
  EXPECT_NEAR(sizes[0].size, 2.0 * sizes[1].size, 1e-12);
  EXPECT_EQ(sizes[0].where, "hip");
  EXPECT_EQ(sizes[0].unit, "rad");
}

TEST(SmallestSizes, BeyondTheLibrarysRangeAreNotPromised) {
  const Screened s({0.1, 0.0});
  EXPECT_TRUE(smallest_sizes(s.library, s.screening).empty());
}

TEST(PatchedModel, PredictsWhatTheSearchsModelDoes) {
  const ModelFolder model = two_links(kNoisyServo);
  const auto recordings = recordings_of(model, 1, 3.0, 1);
  const SmallComparison c(model, recordings, noise_of(model), {"coulomb_friction"});
  Model found = with(c, c.of("coulomb_friction", {1}), {0.07});
  for (std::size_t k = 0; k < found.nuisance.size(); ++k)
    found.nuisance[k] = (k % 2 == 0 ? 0.5 : -0.5) * c.library.nuisances[k].tolerance;
  const ModelFolder patched = patched_model(model, c.library, found);
  const ModelFolder read = parse_model(model_toml(patched), patched.urdf, "model.toml");
  SimParams by_search = c.problem->sources[0].nominal;
  c.library.apply(found, by_search);
  const Drive& drive = c.problem->sources[0].drive;
  const std::vector windows{whole_from_rest(drive)};
  const Prediction a = simulate(by_search, drive, windows).front(),
                   b = simulate(params_with_effects(read), drive, windows).front();
  for (std::size_t k = 0; k < a.q.size(); ++k) ASSERT_NEAR(a.q[k], b.q[k], 1e-9) << k;
}

TEST(PatchedModel, OfNothingIsTheModelItself) {
  const ModelFolder model = two_links(kNoisyServo);
  const SmallComparison c(model, recordings_of(model, 1, 3.0, 1), noise_of(model),
                          {"coulomb_friction"});
  EXPECT_EQ(model_toml(patched_model(model, c.library, nominal(c))), model_toml(model));
}

}  // namespace
}  // namespace sanso::diagnose
