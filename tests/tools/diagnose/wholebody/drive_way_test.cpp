// What a choice of terms gains on rows left out: the least of all ways, and the bound that chance
// leaves.
#include "tools/diagnose/wholebody/drive_way.h"

#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

/// Of twelve groups: ten each without terms; with one, `gains[g]` less.
Gain gain_of(const std::vector<double>& gains, double second_way = 1.0) {
  const test::StanceWorld world({.recordings = 0});
  const DriveTerm term;
  std::vector<Way> ways(2);
  return gain_in(ways, {}, {&term}, world.asking(), [&](const Way& way, const Terms& terms) {
    std::vector<double> left(gains.size(), 10.0);
    const double scale = &way == &ways[1] ? second_way : 1.0;
    for (std::size_t g = 0; g < left.size() && !terms.empty(); ++g) left[g] -= scale * gains[g];
    return left;
  });
}

TEST(Gain, OfEveryGroupAlikeIsCertain) {
  const Gain g = gain_of(std::vector<double>(12, 2.0));
  EXPECT_NEAR(g.share, 0.2, 1e-12);
  EXPECT_NEAR(g.low, 0.2, 1e-12);
}

TEST(Gain, ThatScattersIsNoneForSure) {
  std::vector<double> gains(12, 0.1);
  for (std::size_t g = 0; g < gains.size(); ++g) gains[g] += g < 4 ? 4.0 : -2.0;
  const Gain g = gain_of(gains);
  EXPECT_NEAR(g.share, 0.01, 1e-12);
  EXPECT_LT(g.low, 0.0);
}

TEST(Gain, IsTheLeastOfAllWaysOfCutting) {
  EXPECT_NEAR(gain_of(std::vector<double>(12, 2.0), 0.5).share, 0.1, 1e-12);
  EXPECT_LT(gain_of(std::vector<double>(12, 2.0), -1.0).low, 0.0);
}

}  // namespace
}  // namespace sanso::diagnose
