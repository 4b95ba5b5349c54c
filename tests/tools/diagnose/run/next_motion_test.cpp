// The motion that is asked for can be run: its file reads back, the planner's robot holds its
// clauses, and varying it tells no less.
#include "tools/diagnose/run/next_motion.h"

#include <gtest/gtest.h>

#include "host/app/model_trial.h"
#include "host/app/motion_judge.h"
#include "tests/tools/diagnose/wholebody/made_names.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(NextMotion, CanBeRunAndTells) {
  const MadeNames names(hardly_moving());
  const auto& apart = names.apart;
  ASSERT_TRUE(apart);
  const NextMotion next = next_motion(*apart, Settings{});
  ASSERT_TRUE(next.motion) << next.why_not;
  EXPECT_EQ(next.experiment.kind, ExperimentKind::motion);
  EXPECT_EQ(next.experiment.separates, apart->names());
  EXPECT_GT(next.experiment.nats_per_second, Settings{}.next.least);
  EXPECT_NEAR(next.experiment.seconds_to_100_to_1 * next.experiment.nats_per_second, 4.6052, 1e-3);
  const motion::Motion read = motion::parse_motion(motion::to_toml(*next.motion), "written");
  EXPECT_FALSE(read.success.empty());
  const learn::Episode trial = app::trial_in_model(read);
  EXPECT_TRUE(app::broken_clauses(read, trial).empty());
  // the menu alone, without the variations of its best
  Settings plain;
  plain.next.better = 100.0;
  const NextMotion first = next_motion(*apart, plain);
  EXPECT_GE(next.experiment.nats_per_second, first.experiment.nats_per_second);
}

TEST(NextMotion, OfARobotWithOtherJointsIsNotMade) {
  StanceWorld world(hardly_moving());
  for (std::size_t j = 0; j < world.body.model.tree.joints.size(); ++j)
    world.body.model.tree.joints[j].name = "joint_" + std::to_string(j);
  const auto apart = MadeNames(std::move(world)).apart;
  ASSERT_TRUE(apart);
  const NextMotion next = next_motion(*apart, Settings{});
  EXPECT_FALSE(next.motion);
  EXPECT_NE(next.why_not.find("OP3"), std::string::npos) << next.why_not;
}

}  // namespace
}  // namespace sanso::diagnose
