// A sidecar reads back as written, and every mistake in one is refused by key and line.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "shared/files/input_error.h"
#include "tools/recording/csv_reader.h"
#include "tools/recording/csv_writer.h"
#include "tools/recording/sidecar.h"

namespace sanso::recording {
namespace {

constexpr const char* kText = R"(
[recording]
condition = "kp 400, 200 g"
[robot]
gravity = [0, 1.0, -9.7]
[joint_default]
p_gain = 2.3
[joint.l_knee]
actuator = "passive"
viscous = 1
[[payload]]
link = "shin"
mass = 0.2
com = [0.0, 0.0, -0.1]
)";

TEST(Sidecar, ReadsConditionSettingsAndPayload) {
  Recording r;
  parse_sidecar(kText, "a.toml", r);
  EXPECT_EQ(r.condition, "kp 400, 200 g");
  ASSERT_EQ(r.overrides.size(), 4u);
  EXPECT_EQ(r.overrides[0].table, "robot");
  EXPECT_EQ(r.overrides[0].numbers, (std::vector<double>{0, 1.0, -9.7}));
  EXPECT_EQ(r.overrides[1].key, "p_gain");
  EXPECT_EQ(r.overrides[1].line, 7);
  ASSERT_EQ(r.payloads.size(), 1u);
  EXPECT_EQ(r.payloads[0].com[2], -0.1);
}

TEST(Sidecar, TravelsWithItsRecording) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("sanso_sidecar_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  Recording r;
  r.t = {0, 1};
  r.set("q:l_knee", {0, 1});
  parse_sidecar(kText, "a.toml", r);
  write_csv(r, (folder / "walk.csv.gz").string());
  const Recording back = read_csv((folder / "walk.csv.gz").string());
  EXPECT_EQ(back.condition, r.condition);
  EXPECT_EQ(back.overrides.size(), r.overrides.size());
  EXPECT_EQ(back.payloads[0].link, "shin");
  std::filesystem::remove_all(folder);
}

TEST(Sidecar, TakesForeignLettersInCommentsAndQuotes) {
  Recording r;
  parse_sidecar("\xef\xbb\xbf# f\xc3\xbcr\n[recording]\ncondition = \"k\xc3\xbchl\"\n", "a.toml",
                r);
  EXPECT_EQ(r.condition, "k\xc3\xbchl");
}

TEST(Sidecar, RefusesByKeyAndLine) {
  struct Case {
    const char* text;
    const char* defect;
    int line;
    const char* channel;
  };
  for (const Case& c :
       {Case{"[joint.a]\np_gian = 2\n", "unknown key", 2, "joint.a.p_gian"},
        Case{"[joint.a]\nviscous = -1\n", "out of range", 2, "joint.a.viscous"},
        Case{"[joint.a]\nviscous = \"1\"\n", "not a number", 2, "joint.a.viscous"},
        Case{"[joint.a]\nactuator = \"hydraulic\"\n", "unknown actuator", 2, "joint.a.actuator"},
        Case{"[robot]\ngravity = [0, 1]\n", "wrong list", 2, "robot.gravity"},
        Case{"[robot]\nurdf = \"x\"\n", "unknown key", 2, "robot.urdf"},
        Case{"[[payload]]\nmass = 1\n", "missing key", 1, "payload.link"},
        Case{"payload = 3\n", "not a list of tables", 1, "payload"},
        Case{"joint = 3\n", "not a table", 1, "joint"}, Case{"a = \n", "not valid TOML", 1, ""},
        Case{"\n[*", "not valid TOML", 2, ""}, Case{"[\n", "not valid TOML", 1, ""},
        Case{"[[]]\n", "not valid TOML", 1, ""}, Case{"\n\xc7\xbd", "not valid TOML", 2, ""},
        Case{"b=[}", "not valid TOML", 1, ""}, Case{"b = [1,\n}", "not valid TOML", 2, ""}}) {
    Recording r;
    try {
      parse_sidecar(c.text, "a.toml", r);
      FAIL() << c.text;
    } catch (const files::InputError& e) {
      EXPECT_EQ(e.defect, c.defect) << c.text;
      EXPECT_EQ(e.line, c.line) << e.what();
      EXPECT_EQ(e.channel, c.channel) << e.what();
    }
  }
}

}  // namespace
}  // namespace sanso::recording
