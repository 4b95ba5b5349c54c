// From oscillators and a hand to a motion file: primitives repeat what the robot really did.
#include <gtest/gtest.h>

#include "tools/inprocess/record_motion.h"

namespace sanso::inprocess {
namespace {

constexpr double kDeg = 3.14159265358979323846 / 180.0;

motion::RecordRecipe bob(bool rhythmic) {
  motion::RecordRecipe r = motion::parse_record_recipe(motion::kExampleRecordRecipe, "the example");
  r.rhythmic = rhythmic;
  return r;
}

TEST(Record, PrimitivesRepeatTheRobotDownTheRamp) {
  const motion::Motion like = motion::MotionLibrary().load("skate_ramp");
  const RecordedMotion made = record_motion(bob(false), like, "coast", "lab", "");
  EXPECT_LT(made.fit.joint_rad, 1.0 * kDeg);
  EXPECT_LT(made.fit.position_m, 0.005);
  // it is the robot's motion, not that of the targets, and it did arrive
  EXPECT_GT(made.largest_lag_rad, 0.2 * kDeg);
  const motion::Motion read = motion::parse_motion(motion::to_toml(made.motion), "coast");
  EXPECT_EQ(motion::to_toml(read), motion::to_toml(made.motion));
  EXPECT_GT(read.reference().x.back()[model::kXPos], 1.0);
  ASSERT_TRUE(read.skate);
  EXPECT_EQ(read.skate->ground, "ramp");
}

TEST(Record, CutsWholeCyclesThatCloseOnSoles) {
  motion::RecordRecipe recipe = bob(true);
  recipe.like = "stand";
  recipe.duration_s = 9.0;
  const RecordedMotion made =
      record_motion(recipe, motion::MotionLibrary().load("stand"), "bob", "lab", "");
  ASSERT_EQ(made.wanted.x.size(), 201u);
  EXPECT_EQ(made.motion.primitives.form, policy::PrimitiveForm::rhythmic);
  const auto open = model::joints(made.wanted.x.back()) - model::joints(made.wanted.x.front());
  EXPECT_LT(open.cwiseAbs().maxCoeff(), 0.5 * kDeg);
  EXPECT_LT(made.fit.joint_rad, 1.0 * kDeg);
}

TEST(Record, RefusesWhatItCannotRecord) {
  const motion::Motion like = motion::MotionLibrary().load("skate_ramp");
  motion::RecordRecipe recipe = bob(true);
  recipe.cycles = 20;
  EXPECT_THROW(record_motion(recipe, like, "long", "lab", ""), motion::MotionError);
  EXPECT_THROW(record_motion(bob(false), like, "flat", "lab", "plane"), motion::MotionError);
}

}  // namespace
}  // namespace sanso::inprocess
