// Intervals of findings: as wide as the settings say that sealed cases took.
#include <gtest/gtest.h>

#include <memory>

#include "tests/support/standing_search.h"
#include "tools/diagnose/verdict/finding.h"

namespace sanso::diagnose {
namespace {

VerdictParameter dry_friction_of(const test::Standing& s) {
  const std::vector<Finding> findings = accepted_so_far(s.c.library, s.state.found);
  EXPECT_EQ(findings.size(), 1U);
  return findings.front().parameters.at("coulomb");
}

TEST(FindingInterval, IsStretchedAboutTheSameValue) {
  test::Standing s({test::kRubbing}, {"coulomb_friction"});
  const auto stretched = [&s](double factor) {
    Comparison other = *s.state.problem;
    other.settings.decisions.interval_stretch = factor;
    s.state.found.around->problem.comparison = std::make_shared<const Comparison>(other);
    return dry_friction_of(s);
  };
  const VerdictParameter narrow = stretched(1.0), wide = stretched(1.5);
  EXPECT_EQ(narrow.value, wide.value);
  EXPECT_GT(narrow.high, narrow.low);
  EXPECT_NEAR(wide.high - wide.value, 1.5 * (narrow.high - narrow.value), 1e-12);
  EXPECT_NEAR(wide.value - wide.low, 1.5 * (narrow.value - narrow.low), 1e-12);
}

}  // namespace
}  // namespace sanso::diagnose
