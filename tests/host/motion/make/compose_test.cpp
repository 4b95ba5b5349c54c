// Motions from recipes: what the recipe says is what the body does, and what no robot can do is
// refused by name.
#include "host/motion/make/compose.h"

#include <gtest/gtest.h>

#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/leg_ik.h"
#include "shared/files/input_error.h"

namespace sanso::motion {
namespace {

std::string in_place(const std::string& more) {
  return "format = 1\ntitle = \"t\"\nlike = \"squat\"\n" + more;
}
constexpr const char* kBow =
    "[[pose]]\nat_s = 1.5\nheight_m = -0.04\nleft_m = 0.02\n[[pose]]\nat_s = 3.0\n";

model::State at(const ImportedMotion& made, double t_s) {
  return made.motion.reference().x.at(static_cast<std::size_t>(std::lround(t_s / 0.01)));
}

TEST(Compose, TrunkAndWeightAreWhereTheRecipePutsThem) {
  const ImportedMotion made = compose_motion(in_place(kBow), "bow.toml", "bow");
  const model::State before = at(made, 0.2), low = at(made, 2.5), after = at(made, 4.8);
  EXPECT_NEAR(low[2] - before[2], -0.04, 1e-3);
  EXPECT_NEAR(after[2] - before[2], 0.0, 1e-3);
  const auto weight = [](const model::State& x) { return body_points(x).centre_of_mass().y(); };
  EXPECT_NEAR(weight(low) - weight(before), 0.02, 2e-3);
  for (int side : {kRight, kLeft})
    EXPECT_LT((body_points(low).p_world_foot[static_cast<std::size_t>(side)] -
               body_points(before).p_world_foot[static_cast<std::size_t>(side)])
                  .norm(),
              1.5e-3)
        << "the feet stay";
  EXPECT_EQ(made.motion.name, "bow");
  EXPECT_GT(made.check.zmp_margin_worst_m, 0.0);
}

TEST(Compose, HalfTheSpeedTakesTwiceAsLongOnTheSameWay) {
  const ImportedMotion fast = compose_motion(in_place(kBow), "a", "a");
  const ImportedMotion slow =
      compose_motion(in_place("speed = 0.5\n" + std::string(kBow)), "b", "b");
  EXPECT_NEAR(slow.motion.duration_s() - fast.motion.duration_s(), 3.0, 0.11);
  EXPECT_NEAR(at(fast, 2.5)[2], at(slow, 4.0)[2], 1e-3);
  EXPECT_LT(slow.check.peak_joint_speed, 0.6 * fast.check.peak_joint_speed);
}

TEST(Compose, FeetLandWhereTheExampleSaysAndTheWeightIsOverTheOther) {
  const ImportedMotion made = compose_motion(kExampleRecipe, "example.toml", "example");
  EXPECT_EQ(made.motion.recipe.kind, MotionKind::gait);
  const BodyPoints before = body_points(at(made, 0.2)),
                   after = body_points(at(made, made.motion.duration_s() - 0.2));
  for (std::size_t side = 0; side < 2; ++side) {
    EXPECT_NEAR(after.p_world_foot[side].x() - before.p_world_foot[side].x(), 0.04, 2e-3);
    EXPECT_NEAR(after.p_world_foot[side].z() - before.p_world_foot[side].z(), 0.0, 1.5e-3);
  }
  const BodyPoints swinging = body_points(at(made, 1.0 + 3.5));
  EXPECT_GT(swinging.p_world_foot[kRight].z(), before.p_world_foot[kRight].z() + 0.015);
  EXPECT_NEAR(swinging.p_world_foot[kLeft].z(), before.p_world_foot[kLeft].z(), 1.5e-3);
  EXPECT_GT(made.check.zmp_margin_worst_m, 0.0);
  EXPECT_GT(made.motion.window.from_s, 4.0) << "stands, bows, then steps";
}

TEST(Compose, WhatItWritesIsAMotionFile) {
  const ImportedMotion made = compose_motion(in_place(kBow), "bow.toml", "bow");
  const Motion again = parse_motion(to_toml(made.motion), "bow");
  EXPECT_EQ(to_toml(again), to_toml(made.motion));
}

TEST(Compose, WhatTheRobotCannotDoIsRefusedWithWhatToChange) {
  const char* impossible[] = {
      "[[pose]]\nat_s = 0.1\nheight_m = -0.1\n[[pose]]\nat_s = 0.2\n",            // too fast
      "[[pose]]\nat_s = 2\nleft_m = 0.08\n[[pose]]\nat_s = 4\n",                  // tips over
      "kappa = 0.98\n[[pose]]\nat_s = 2\nheight_m = 0.03\n[[pose]]\nat_s = 4\n",  // out of reach
  };
  for (const char* recipe : impossible) try {
      (void)compose_motion(in_place(recipe), "x.toml", "x");
      ADD_FAILURE() << recipe;
    } catch (const ClipError& error) {
      EXPECT_NE(std::string(error.what()).find("Next:"), std::string::npos);
      EXPECT_EQ(std::string(error.what()).find("lower kz"), std::string::npos)
          << "figures of another kind of recipe";
    }
}

TEST(Compose, ARecipeThatSaysNoMotionNamesLineAndKey) {
  const std::pair<std::string, const char*> wrong[] = {
      {in_place("[[pose]]\nat_s = 1\nheight_m = -0.02\n"), "last pose"},
      {in_place("[[pose]]\nat_s = 2\n[[pose]]\nat_s = 1\n"), "at_s"},
      {in_place(""), "nothing moves"},
      {in_place("[[pose]]\nat_s = 1\nheigth_m = -0.02\n"), "heigth_m"},
      {in_place("[[step]]\nfoot = \"right\"\nlift_s = 0.1\nland_s = 0.7\n"), "lift_s"},
      {in_place("[[step]]\nfoot = \"middle\"\nlift_s = 1\nland_s = 2\n"), "foot"},
      {in_place("[[step]]\nfoot = \"left\"\nlift_s = 1\nland_s = 2\n[[step]]\nfoot = \"right\"\n"
                "lift_s = 1.5\nland_s = 2.5\n"),
       "lift_s"},
      {"format = 2\ntitle = \"t\"\nlike = \"squat\"\n", "format"},
  };
  for (const auto& [recipe, word] : wrong) try {
      (void)compose_motion(recipe, "x.toml", "x");
      ADD_FAILURE() << recipe;
    } catch (const files::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  EXPECT_THROW((void)compose_motion(
                   "format = 1\ntitle = \"t\"\nlike = \"fly\"\n" + std::string(kBow), "x", "x"),
               MotionError);
}

}  // namespace
}  // namespace sanso::motion
