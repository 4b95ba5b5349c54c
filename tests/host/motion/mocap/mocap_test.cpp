// Readers of human clips: positions by hand calculation, and messages that say where and what.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/motion/mocap/bvh.h"
#include "host/motion/mocap/contacts.h"
#include "host/motion/mocap/deepmimic.h"
#include "host/motion/mocap/filter.h"

namespace sanso::motion {
namespace {

using ::testing::HasSubstr;

const char* const kTwoBones =
    "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation "
    "Xrotation Yrotation\n"
    " JOINT Knee\n {\n  OFFSET 0 -40 0\n  CHANNELS 3 Zrotation Xrotation Yrotation\n  End Site\n  "
    "{\n   OFFSET 0 -40 0\n"
    "  }\n }\n}\nMOTION\nFrames: 2\nFrame Time: 0.0333\n1 90 2 0 0 0 0 0 0\n1 90 2 90 0 0 0 0 0\n";

std::string message_of(const std::string& text) {
  try {
    parse_bvh(text, "clip.bvh");
  } catch (const ClipError& error) {
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  return text.replace(text.find(what), what.size(), with);
}

TEST(Bvh, PositionsFollowTheChannels) {
  const BvhClip clip = parse_bvh(kTwoBones, "clip.bvh");
  ASSERT_EQ(clip.joints.size(), 2u);
  ASSERT_EQ(clip.frames.size(), 2u);
  EXPECT_DOUBLE_EQ(clip.frame_time_s, 0.0333);
  EXPECT_LT((clip.positions(0)[1] - Eigen::Vector3d(1, 50, 2)).norm(), 1e-12);
  // the root turned by 90 deg about z: the bone that hung down points to +x
  EXPECT_LT((clip.positions(1)[1] - Eigen::Vector3d(41, 90, 2)).norm(), 1e-12);
}

TEST(Bvh, MessagesNameLineAndExpectation) {
  EXPECT_THAT(message_of(replaced(kTwoBones, "OFFSET 0 -40 0", "OFFSET 0 minus 0")),
              HasSubstr("clip.bvh:8: found 'minus', expected a number"));
  EXPECT_THAT(message_of(replaced(kTwoBones, "Xposition", "Wposition")),
              HasSubstr("one of Xposition .. Zrotation"));
  EXPECT_THAT(message_of(replaced(kTwoBones, "Frames: 2", "Frames: 3")), HasSubstr("end of file"));
  EXPECT_THAT(message_of(replaced(kTwoBones, "Frames: 2", "Frames: 1")),
              HasSubstr("end of the file after 1 frames"));
  EXPECT_THAT(message_of(replaced(kTwoBones, "Frame Time: 0.0333", "Frame Time: 0")),
              HasSubstr("above 0 s"));
  EXPECT_THAT(message_of("nonsense"),
              HasSubstr("clip.bvh:1: found 'nonsense', expected 'HIERARCHY'"));
  EXPECT_THROW(read_bvh("/nonexistent/clip.bvh"), ClipError);
}

TEST(Bvh, AskingForAMissingJointNamesTheOnesThereAre) {
  try {
    human_from_bvh(parse_bvh(kTwoBones, "clip.bvh"));
    FAIL() << "a skeleton without legs was taken";
  } catch (const ClipError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the file has Hips, Knee"));
  }
}

std::string deepmimic_row(double root_x, double knee_angle) {
  const std::string row = "[0.1," + std::to_string(root_x) + ",0.9,0,1,0,0,0,1,0,0,0,1,0,0,0";
  const std::string leg = ",1,0,0,0," + std::to_string(knee_angle) + ",1,0,0,0", arm = ",1,0,0,0,0";
  return row + leg + arm + leg + arm + "]";
}

TEST(DeepMimic, LegsHangStraightDownAndKneesBendBackwards) {
  const HumanMotion motion =
      parse_deepmimic("{\"Loop\":\"wrap\",\"Frames\":[" + deepmimic_row(0.0, 0.0) + "," +
                          deepmimic_row(0.2, -1.0) + "]}",
                      "jog.txt");
  ASSERT_EQ(motion.frames.size(), 2u);
  EXPECT_TRUE(motion.loops);
  const HumanLeg& left = motion.frames[0].leg[kLeft];
  EXPECT_GT(left.hip.y(), 0.0) << "left is +y";
  EXPECT_NEAR(left.hip.z() - left.ankle.z(), 0.4215 + 0.4099, 1e-9);
  EXPECT_LT(motion.frames[1].leg[kLeft].ankle.x(), motion.frames[1].leg[kLeft].knee.x() - 0.2);
}

TEST(DeepMimic, MessagesNameTheRow) {
  EXPECT_THROW(parse_deepmimic("{", "jog.txt"), ClipError);
  try {
    parse_deepmimic("{\"Frames\":[" + deepmimic_row(0, 0) + ",[1,2,3]]}", "jog.txt");
    FAIL();
  } catch (const ClipError& error) {
    EXPECT_THAT(error.what(), HasSubstr("jog.txt: Frames[1]: found 3 values, expected 44 numbers"));
  }
}

TEST(LowPass, KeepsConstantsLinesAndSlowWaves) {
  std::vector<double> line, slow, fast;
  for (int k = 0; k < 400; ++k) {
    line.push_back(0.5 + 0.01 * k);
    slow.push_back(std::sin(2 * M_PI * 0.5 * k * 0.01));
    fast.push_back(std::sin(2 * M_PI * 30 * k * 0.01));
  }
  const auto line_out = low_pass(line, 0.01, 6), slow_out = low_pass(slow, 0.01, 6),
             fast_out = low_pass(fast, 0.01, 6);
  for (std::size_t k = 0; k < line.size(); ++k)
    EXPECT_NEAR(line_out[k], line[k], 2e-3) << "sample " << k;
  for (std::size_t k = 50; k < 350; ++k) {
    EXPECT_NEAR(slow_out[k], slow[k], 1e-3);  // no delay
    EXPECT_LT(std::abs(fast_out[k]), 0.01);
  }
}

/// A man made of points who walks along a heading at 1 m/s: each foot stands 0.6 s and swings 0.4
/// s.
HumanMotion synthetic_walk(double heading_rad, double floor_slope) {
  HumanMotion motion;
  motion.dt_s = 0.01;
  motion.source = "synthetic";
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  for (int k = 0; k < 500; ++k) {
    const double t = 0.01 * k;
    HumanFrame frame;
    for (int side : {kRight, kLeft}) {
      const double phase = t + (side == kLeft ? 0.5 : 0.0), cycle = std::floor(phase),
                   u = phase - cycle;
      const double swing = std::max(0.0, (u - 0.6) / 0.4);
      const double foot_x = cycle + swing - (side == kLeft ? 0.5 : 0.0),
                   lift = 0.15 * std::sin(M_PI * swing);
      const double y = side_sign(side) * 0.1;
      frame.leg[side] = {
          {t, y, 0.9}, {t, y, 0.5}, {foot_x, y, 0.1 + lift}, {foot_x + 0.15, y, 0.03 + lift}};
    }
    for_each_point(frame, [&](Eigen::Vector3d& p) {
      p = Eigen::Vector3d(c * p.x() - s * p.y(), s * p.x() + c * p.y(),
                          p.z() + floor_slope * p.x());
    });
    motion.frames.push_back(frame);
  }
  return motion;
}

TEST(Contacts, FindsTheStancesOfAWalkOnATiltedFloor) {
  const auto all = stances(floor_levelled(aligned(synthetic_walk(0.7, 0.01), false)));
  int whole = 0;
  for (const auto& stance : all) {
    if (!stance.whole) continue;
    ++whole;
    EXPECT_NEAR(stance.to_s - stance.from_s, 0.6, 0.1);
    EXPECT_NEAR(stance.p.y(), side_sign(stance.side) * 0.1, 0.02);
  }
  EXPECT_GE(whole, 6);
}

TEST(Contacts, TravelComesToLieAlongX) {
  const HumanMotion walk = aligned(synthetic_walk(2.1, 0.0), false);
  EXPECT_NEAR(walk.frames.back().hips().x(), 4.99, 0.01);
  EXPECT_NEAR(walk.frames.back().hips().y(), 0.0, 0.01);
}

}  // namespace
}  // namespace sanso::motion
