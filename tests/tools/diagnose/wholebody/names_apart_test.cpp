// What would tell names apart: motion that shows the difference, the more the longer it lasts, and
// nothing that the rival can imitate.
#include "tools/diagnose/wholebody/names_apart.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/diagnose/wholebody/made_stance.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A robot that stands still, held by friction that the model does not have.
Stance still() {
  Stance out;
  out.recordings = 5, out.seconds = 4.0;
  out.moves = [](int) { return 0.0; };
  out.drive = [](int) { return TrueDrive{.coulomb = 0.2}; };
  return out;
}

struct Undecided {
  StanceWorld world{still()};
  DriveBalance found = balance_drives(world.asking());
  std::shared_ptr<const NamesApart> apart = names_apart(world.asking(), found.rows, found.choice);

  std::string told() const {
    std::string out;
    for (const std::string& line : found.choice.log) out += line + "\n";
    for (const JudgedDriveTerm& j : found.choice.terms)
      for (const DriveTerm& rival : j.rivals) out += "or " + in_words(rival) + "\n";
    return out;
  }
  double nats(double share, double seconds) const {
    Stance tried = still();
    tried.seconds = seconds;
    tried.moves = [share](int) { return share; };
    return apart->nats(recorded(world.body, tried, 99));
  }
};

TEST(NamesApart, OfARobotThatStoodStillMotionTells) {
  const Undecided u;
  ASSERT_TRUE(u.apart) << u.told();
  EXPECT_GE(u.apart->names().size(), 2u);
  EXPECT_FALSE(u.apart->current());
  EXPECT_TRUE(u.apart->feet().empty());
  EXPECT_GT(u.nats(1.0, 8.0), 3.0) << u.told();
}

TEST(NamesApart, MoreOfItTellsMore) {
  const Undecided u;
  ASSERT_TRUE(u.apart) << u.told();
  double before = 0.0;
  for (const double seconds : {2.0, 4.0, 8.0}) {
    const double now = u.nats(1.0, seconds);
    EXPECT_GT(now, before);
    before = now;
  }
}

TEST(NamesApart, ARecordingThatHoldsNothingTellsNothing) {
  const Undecided u;
  ASSERT_TRUE(u.apart) << u.told();
  Stance other = still();
  WholeRecording without = recorded(u.world.body, other, 99);
  without.current = true;  // no such rows were asked before
  EXPECT_EQ(u.apart->nats(without), 0.0);
  without.acc = false;
  EXPECT_EQ(u.apart->nats(without), 0.0);
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
