// What would tell names apart: motion that shows the difference, the more the longer it lasts, and
// nothing that the rival can imitate.
#include "tools/diagnose/wholebody/names_apart.h"

#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_names.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(NamesApart, FrictionsAreToldByMotion) {
  const MadeNames names(hardly_moving());
  ASSERT_TRUE(names.apart);
  EXPECT_EQ(names.apart->names(),
            (std::vector<std::string>{std::string(effect_of(JointFigure::speed)->id),
                                      std::string(effect_of(JointFigure::dry)->id)}));
  EXPECT_FALSE(names.apart->current());
  EXPECT_TRUE(names.apart->feet().empty());
  EXPECT_NEAR(names.nats(0.0, 8.0), 0.0, 1e-6) << "what stands has no speed";
  EXPECT_GT(names.nats(1.0, 8.0), 5.0);
}

TEST(NamesApart, MoreOfItTellsMore) {
  const MadeNames names(hardly_moving());
  ASSERT_TRUE(names.apart);
  double before = 0.0;
  for (const double seconds : {2.0, 4.0, 8.0}) {
    const double now = names.nats(1.0, seconds);
    EXPECT_GT(now, before);
    before = now;
  }
}

TEST(NamesApart, ARecordingThatHoldsNothingTellsNothing) {
  const MadeNames names(hardly_moving());
  ASSERT_TRUE(names.apart);
  WholeRecording other = recorded(names.world.body, Stance{}, 99);
  other.current = true;  // no such rows were asked before
  EXPECT_EQ(names.apart->nats(other), 0.0);
  other.current = other.acc = false;
  EXPECT_EQ(names.apart->nats(other), 0.0);
}

TEST(NamesApart, WhatIsDecidedAsksForNothing) {
  Stance stance;
  stance.drive = [](int) { return TrueDrive{.gain = 0.7}; };
  const StanceWorld world(stance);
  const DriveBalance found = balance_drives(world.asking());
  EXPECT_FALSE(names_apart(world.asking(), found.rows, found.choice));
}

}  // namespace
}  // namespace sanso::diagnose
