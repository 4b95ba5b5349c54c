// Names that say no more than a simpler one give it their place.
#include <gtest/gtest.h>

#include "tests/support/standing_search.h"

namespace sanso::diagnose {
namespace {

using namespace test;

const std::vector<std::string> kRubs{"coulomb_friction", "presliding_friction"};

TEST(Simplify, FrictionThatBuildsUpAtOnceIsDryFriction) {
  Standing s({kRubbing}, {"presliding_friction"}, kRubs);
  EXPECT_TRUE(simplify(s.state));
  EXPECT_EQ(s.names(), Names{"coulomb_friction"});
  EXPECT_TRUE(s.said("says how dry friction builds up"));
  EXPECT_NEAR(s.state.found.final.model.effects[0].theta[0], 0.08, 0.01);
  EXPECT_FALSE(simplify(s.state)) << "there is no simpler name";
}

TEST(Simplify, BesideDryFrictionItLeaves) {
  Standing s({kRubbing}, {"coulomb_friction", "presliding_friction"}, kRubs);
  EXPECT_TRUE(simplify(s.state));
  EXPECT_EQ(s.names(), Names{"coulomb_friction"});
  EXPECT_NEAR(s.state.found.final.model.effects[0].theta[0], 0.08, 0.01);
  EXPECT_TRUE(s.state.given_up.empty()) << "its part is needed";
}

TEST(Simplify, OfWhichNotEvenAPartIsNeededIsNotAskedAgain) {
  Standing s({}, {"presliding_friction"}, kRubs);
  EXPECT_TRUE(simplify(s.state));
  EXPECT_TRUE(s.names().empty());
  EXPECT_EQ(s.state.given_up, std::vector{s.c.of("presliding_friction")});
}

TEST(Simplify, FrictionThatBendsStays) {
  const EffectEntry bends = hidden("presliding_friction", "a",
                                   {{"coulomb", 0.1}, {"compliance", 0.08}, {"damping", 0.05}});
  Standing s({bends}, {"presliding_friction"}, kRubs);
  EXPECT_FALSE(simplify(s.state));
  EXPECT_EQ(s.names(), Names{"presliding_friction"});
}

}  // namespace
}  // namespace sanso::diagnose
