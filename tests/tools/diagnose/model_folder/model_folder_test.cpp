// A model folder reads back as written, and every mistake in one is refused by key and line.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "shared/files/input_error.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/recording/sidecar.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kUrdf = R"(<robot name="two"><link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 2 0"/>
<limit lower="-1" upper="1" effort="3" velocity="2"/></joint>
<link name="upper"><inertial><origin xyz="0 0 -0.1"/><mass value="1"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="glue" type="fixed"><parent link="upper"/><child link="box"/><origin xyz="0 0 -0.2"/>
</joint>
<link name="box"><inertial><mass value="3"/>
<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
<joint name="b" type="prismatic"><parent link="box"/><child link="rod"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" effort="3" velocity="2"/></joint>
<link name="rod"><inertial><mass value="0.5"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link></robot>)";

constexpr const char* kToml = R"(format = 1
[robot]
gravity = [0.0, 0.0, -9.8]
[control]
period_s = 0.02
[joint_default]
actuator = "dc_servo"
p_gain = 4.0
[joint.b]
actuator = "torque"
viscous = 0.25
[[effect]]
id = "backlash"
where = ["a"]
width = 0.021
)";

TEST(ModelFolder, ReadsSettingsByJoint) {
  const ModelFolder m = parse_model(kToml, kUrdf, "model.toml");
  EXPECT_EQ(m.gravity[2], -9.8);
  EXPECT_EQ(m.period_s, 0.02);
  ASSERT_EQ(m.joints.size(), 2u);
  EXPECT_EQ(m.joints[0].p_gain, 4.0);
  EXPECT_EQ(m.joints[0].resistance, 5.22) << "what is not written keeps its documented default";
  EXPECT_EQ(m.joints[1].actuator, Actuator::torque);
  EXPECT_EQ(m.joints[1].viscous, 0.25);
  ASSERT_EQ(m.effects.size(), 1u);
  EXPECT_EQ(m.effects[0].parameters.at("width"), 0.021);
}

TEST(ModelFolder, MergesFixedJointsIntoOneBody) {
  const ModelFolder m = parse_model(kToml, kUrdf, "model.toml");
  ASSERT_EQ(m.tree.size(), 2u);
  const TreeJoint& a = m.tree.joints[0];
  EXPECT_EQ(a.axis[1], 1.0) << "axes are made unit vectors";
  EXPECT_EQ(a.body.mass, 4.0);
  EXPECT_NEAR(a.body.com[2], (1 * -0.1 + 3 * -0.2) / 4, 1e-15);
  // two points 0.1 m apart: reduced mass times distance squared, none about their common line
  EXPECT_NEAR(a.body.about_com[0], 0.75 * 0.01, 1e-15);
  EXPECT_NEAR(a.body.about_com[8], 0.0, 1e-15);
  EXPECT_EQ(m.tree.joints[1].parent, 0);
  EXPECT_EQ(m.tree.joints[1].p_parent_joint[2], -0.2);
  EXPECT_TRUE(m.tree.joints[1].prismatic);
}

TEST(ModelFolder, WritesWhatItReads) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("sanso_model_" + std::to_string(::getpid()));
  const ModelFolder m = parse_model(kToml, kUrdf, "model.toml");
  write_model_folder(m, folder.string());
  const ModelFolder back = read_model_folder(folder.string());
  EXPECT_EQ(model_toml(back), model_toml(m));
  EXPECT_EQ(back.joints, m.joints);
  EXPECT_EQ(back.urdf, m.urdf);
  EXPECT_EQ(back.effects[0].parameters, m.effects[0].parameters);
  std::filesystem::remove_all(folder);
}

TEST(ModelFolder, RefusesByKeyAndLine) {
  struct Case {
    const char* text;
    const char* defect;
    int line;
    const char* key;
  };
  for (const Case& c :
       {Case{"[robot]\n", "missing key", 1, "format"},  //
        Case{"format = 2\n", "unknown format", 1, "format"},
        Case{"format = 1\nspeed = 2\n", "unknown key", 2, "speed"},
        Case{"format = 1\n[joint.c]\nkp = 1\n", "unknown joint", 2, "joint.c"},
        Case{"format = 1\n[joint.a]\nkpp = 1\n", "unknown key", 3, "joint.a.kpp"},
        Case{"format = 1\n[joint_default]\nduty_limit = 1.5\n", "out of range", 3,
             "joint_default.duty_limit"},
        Case{"format = 1\n[robot]\nbase = \"loose\"\n", "unknown base", 3, "robot.base"},
        Case{"format = 1\n[[effect]]\nwhere = []\n", "missing key", 2, "effect.id"},
        Case{"format = 1\n[[effect]]\nid = \"x\"\nwidth = \"wide\"\n", "not a number", 4,
             "effect.width"}}) {
    try {
      parse_model(c.text, kUrdf, "model.toml");
      FAIL() << c.text;
    } catch (const files::InputError& e) {
      EXPECT_EQ(e.defect, c.defect) << c.text;
      EXPECT_EQ(e.line, c.line) << e.what();
      EXPECT_EQ(e.channel, c.key) << e.what();
    }
  }
}

TEST(ModelFolder, RefusesRobotsThatAreNone) {
  for (const char* urdf :
       {"", "<robot name='x'/>", "<robot name='x'><link name='a'/></robot>", "not xml",
        "<robot name='x'><link name='a'/><link name='b'/><joint name='j' type='floating'><parent "
        "link='a'/><child link='b'/></joint></robot>"}) {
    EXPECT_THROW(parse_model("format = 1\n", urdf, "model.toml"), files::InputError) << urdf;
  }
}

TEST(ModelFolder, SidecarSettingsWinOverTheModel) {
  const ModelFolder m = parse_model(kToml, kUrdf, "model.toml");
  recording::Recording r;
  recording::parse_sidecar(
      "[joint.b]\nviscous = 0.5\n[joint_default]\nviscous = 0.1\n"
      "[robot]\ngravity = [1, 0, 0]\n[[payload]]\nlink = \"box\"\nmass = 4\ncom = [0, 0, 0.1]\n",
      "r.toml", r);
  const ModelFolder changed = with_overrides(m, r);
  EXPECT_EQ(changed.joints[0].viscous, 0.1);
  EXPECT_EQ(changed.joints[1].viscous, 0.5);
  EXPECT_EQ(changed.gravity[0], 1.0);
  EXPECT_EQ(changed.tree.joints[0].body.mass, 4.0) << "the link's own mass is not the payload's";
  ASSERT_EQ(changed.payloads.size(), 1u);
  EXPECT_EQ(changed.payloads[0].joint, 0);
  EXPECT_EQ(changed.payloads[0].body.mass, 4.0);
  EXPECT_NEAR(changed.payloads[0].body.com[2], -0.1, 1e-15);
  EXPECT_EQ(m.joints[0].viscous, 0.0) << "the model itself stays";
  recording::Recording unknown;
  recording::parse_sidecar("[joint.c]\nviscous = 0.5\n", "r.toml", unknown);
  EXPECT_THROW(with_overrides(m, unknown), files::InputError);
}

}  // namespace
}  // namespace sanso::diagnose
