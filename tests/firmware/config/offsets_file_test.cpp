// The OP3's offsets file: the maker's form is read, mistakes are named with their line.
#include "firmware/config/offsets_file.h"

#include <gtest/gtest.h>

namespace sanso::firmware {
namespace {

constexpr char kFile[] = R"(offset:
  head_pan: 0
  l_ank_pitch: 0.034906585
  r_hip_yaw: -0.0174532925
init_pose_for_offset_tuner:
  head_pan: 0
  r_knee: -1.0
)";

TEST(OffsetsFile, TheMakersFormIsReadByServoId) {
  JointOffsets offsets{};
  std::string error;
  ASSERT_TRUE(parse_offsets(kFile, "offset.yaml", offsets, error)) << error;
  EXPECT_DOUBLE_EQ(offsets[16 - 1], 0.034906585);
  EXPECT_DOUBLE_EQ(offsets[7 - 1], -0.0174532925);
  EXPECT_EQ(offsets[13 - 1], 0.0) << "the tuner's pose is no offset";
}

TEST(OffsetsFile, MistakesAreNamedWithTheirLineAndChangeNothing) {
  struct Row {
    const char* text;
    const char* expected;
  };
  for (const Row& row :
       {Row{"offset:\n  r_hip: 0.1\n", "f:2: offset.r_hip: expected a joint of the OP3"},
        Row{"offset:\n  r_knee: 0.1\n  r_knee: 0.2\n", "f:3: offset.r_knee: given twice"},
        Row{"offset:\n  r_knee: 5\n", "f:2: offset.r_knee = 5: expected radians"},
        Row{"offset:\n  r_knee: nan\n", "expected radians"},
        Row{"offset:\n  r_knee: 0.1x\n", "expected radians"}, Row{"a: 1\n", "expected a mapping"},
        Row{"offset: [\n", "f:"}, Row{"", "expected a mapping"}}) {
    JointOffsets offsets{};
    offsets[0] = 0.25;
    std::string error;
    EXPECT_FALSE(parse_offsets(row.text, "f", offsets, error)) << row.text;
    EXPECT_NE(error.find(row.expected), std::string::npos) << error;
    EXPECT_EQ(offsets[0], 0.25);
  }
}

}  // namespace
}  // namespace sanso::firmware
