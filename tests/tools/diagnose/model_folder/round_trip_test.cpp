// Writing a model and reading it again loses nothing; what is written says where it is wrong; what
// a recording says of itself wins, in any order.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "tests/support/small_world.h"
#include "tests/support/temp_folder.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/stats/random.h"
#include "tools/recording/sidecar.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A value that `visit` allows: its range, or 0 .. 10 where it has no end.
double random_within(double low, double high, Random& random) {
  const double top = std::isfinite(high) ? high : low + 10.0;
  return low + (top - low) * random.uniform();
}

void draw(JointSettings& settings, Random& random) {
  JointSettings::visit(
      settings, [&](std::string_view, double& value, std::string_view, double low, double high) {
        if (random.uniform() < 0.6) value = random_within(low, high, random);
      });
  settings.actuator = static_cast<Actuator>(random.below(4));
}

ModelFolder random_model(std::uint64_t seed) {
  Random random(seed);
  ModelFolder m = arm("");
  m.period_s = 0.001 + random.uniform();
  for (double& g : m.gravity) g = 10.0 * random.normal();
  draw(m.joint_default, random);
  for (JointSettings& joint : m.joints) {
    joint = m.joint_default;
    if (random.uniform() < 0.7) draw(joint, random);
  }
  for (int k = 0; k < 3; ++k) {
    EffectEntry e{"effect_" + std::to_string(k), {"a", "b"}, {}, 0};
    e.parameters["width"] = random.normal() * std::pow(10.0, 12 * random.uniform() - 6);
    m.effects.push_back(e);
  }
  return m;
}

TEST(RoundTrip, EveryModelReadsBackToTheLastBit) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const ModelFolder m = random_model(seed);
    const ModelFolder back = parse_model(model_toml(m), m.urdf, "model.toml");
    EXPECT_EQ(back.joint_default, m.joint_default) << "seed " << seed;
    EXPECT_EQ(back.joints, m.joints) << "seed " << seed;
    EXPECT_EQ(back.gravity, m.gravity);
    EXPECT_EQ(back.period_s, m.period_s);
    ASSERT_EQ(back.effects.size(), m.effects.size());
    for (std::size_t k = 0; k < m.effects.size(); ++k) {
      EXPECT_EQ(back.effects[k].id, m.effects[k].id);
      EXPECT_EQ(back.effects[k].where, m.effects[k].where);
      EXPECT_EQ(back.effects[k].parameters, m.effects[k].parameters);
    }
    EXPECT_EQ(model_toml(back), model_toml(m)) << "written again it is the same text";
  }
}

TEST(RoundTrip, OnlyWhatDiffersFromTheDefaultIsWrittenForAJoint) {
  ModelFolder m = arm("viscous = 0.5\n");
  m.joints[1].viscous = 0.7;
  const std::string text = model_toml(m);
  const std::string own = text.substr(text.find("[joint.b]"));
  EXPECT_EQ(own, "[joint.b]\nviscous = 0.7  # N m s/rad\n");
  EXPECT_EQ(text.find("[joint.a]"), std::string::npos);
}

TEST(RoundTrip, NamesOfJointsMayBeAwkward) {
  std::string urdf = kPendulumUrdf;
  urdf.replace(urdf.find("name=\"a\""), 8, "name=\"l.knee 2\"");
  ModelFolder m = parse_model("format = 1\n", urdf, "model.toml");
  m.joints[0].coulomb = 0.25;
  EXPECT_EQ(parse_model(model_toml(m), urdf, "model.toml").joints[0].coulomb, 0.25);
}

TEST(RoundTrip, AFloatingRobotKeepsItsGround) {
  for (const GroundKind kind :
       {GroundKind::plane, GroundKind::ramp, GroundKind::jump_ramp, GroundKind::heights}) {
    const ModelFolder m = parse_model(
        std::string("format = 1\n[robot]\nbase = \"floating\"\n[ground]\nfriction = 0.3\n") +
            "kind = \"" + to_string(kind) + "\"\n",
        kPendulumUrdf, "model.toml");
    EXPECT_EQ(m.ground_kind, kind);
    const ModelFolder back = parse_model(model_toml(m), m.urdf, "model.toml");
    EXPECT_TRUE(back.floating);
    EXPECT_EQ(back.ground_kind, kind);
    EXPECT_EQ(back.ground_friction, 0.3);
  }
}

TEST(RoundTrip, AFolderOnDiskIsReplacedWholeAndLeavesNothingBeside) {
  const sanso::test::TempFolder temporary;
  const std::string folder = (temporary.path() / "new" / "model").string();
  write_model_folder(random_model(1), folder);
  write_model_folder(random_model(2), folder);
  const ModelFolder back = read_model_folder(folder);
  EXPECT_EQ(back.joints, random_model(2).joints);
  EXPECT_EQ(back.folder, folder);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files += entry.is_regular_file();
  EXPECT_EQ(files, 2);
}

TEST(RoundTrip, WhereNothingCanBeWrittenThatIsSaid) {
  const sanso::test::TempFolder temporary;
  const std::string blocked = (temporary.path() / "file").string();
  std::ofstream(blocked) << "in the way";
  EXPECT_THROW(write_model_folder(pendulum(""), blocked), files::WriteError);
}

/// The error that reading this model.toml gives.
files::InputError error_of(const std::string& toml) {
  try {
    parse_model(toml, kArmUrdf, "model.toml");
  } catch (const files::InputError& e) {
    return e;
  }
  return {"", 0, "", "none", "", ""};
}

TEST(ModelErrors, EveryUnknownKeyIsNamedWithItsLineWhereverItStands) {
  for (const char* table : {"robot", "control", "joint_default", "joint.a", "ground"}) {
    for (int blank = 0; blank < 4; ++blank) {
      const std::string toml = "format = 1\n" + std::string(static_cast<std::size_t>(blank), '\n') +
                               "[" + table + "]\nunheard_of = 1\n";
      const files::InputError e = error_of(toml);
      EXPECT_EQ(e.defect, "unknown key") << table;
      EXPECT_EQ(e.line, 3 + blank) << table;
      EXPECT_EQ(e.channel, std::string(table) + ".unheard_of");
    }
  }
}

TEST(ModelErrors, EverySettingRefusesWhatIsBelowItsRangeAndWhatIsNoNumber) {
  JointSettings settings;
  JointSettings::visit(settings, [&](std::string_view key, double&, std::string_view, double low,
                                     double) {
    const std::string name(key);
    const files::InputError below =
        error_of("format = 1\n[joint.b]\n" + name + " = " + std::to_string(low - 1.0) + "\n");
    EXPECT_EQ(below.defect, "out of range") << name;
    EXPECT_EQ(below.line, 3) << name;
    EXPECT_EQ(below.channel, "joint.b." + name);
    EXPECT_EQ(error_of("format = 1\n[joint.b]\n" + name + " = \"much\"\n").defect, "not a number")
        << name;
  });
}

TEST(ModelErrors, AnUnknownActuatorIsToldWhichThereAre) {
  const files::InputError e = error_of("format = 1\n[joint_default]\nactuator = \"steam\"\n");
  EXPECT_EQ(e.defect, "unknown actuator");
  EXPECT_EQ(e.value, "steam");
  for (const std::string_view name : recording::kActuatorNames)
    EXPECT_NE(e.expected.find(name), std::string::npos) << name;
}

TEST(ModelErrors, AFolderThatIsNotThereAndOneWithoutItsFiles) {
  const sanso::test::TempFolder temporary;
  const std::string folder = temporary.path().string();
  EXPECT_THROW(read_model_folder(folder + "/nowhere"), files::InputError);
  std::ofstream(folder + "/model.toml") << "format = 1\n[robot]\nurdf = \"other.urdf\"\n";
  try {
    read_model_folder(folder);
    FAIL();
  } catch (const files::InputError& e) {
    EXPECT_NE(std::string(e.what()).find("other.urdf"), std::string::npos);
  }
}

ModelFolder overridden(const ModelFolder& model, const std::string& sidecar) {
  recording::Recording r;
  r.file = "r.csv";
  recording::parse_sidecar(sidecar, "r.toml", r);
  return with_overrides(model, r);
}

TEST(Overrides, EverySettingOfEveryJointCanBeSaidByARecording) {
  Random random(5);
  JointSettings settings;
  JointSettings::visit(
      settings, [&](std::string_view key, double&, std::string_view, double low, double high) {
        const double value = random_within(low, high, random);
        const std::string line = std::string(key) + " = " + std::to_string(value) + "\n";
        const ModelFolder changed = overridden(arm(""), "[joint.b]\n" + line);
        const ModelFolder expected = parse_model("format = 1\n[joint.b]\n" + line, kArmUrdf, "m");
        EXPECT_EQ(changed.joints, expected.joints) << key;
      });
}

TEST(Overrides, AJointsOwnWordWinsOverTheDefaultInEitherOrder) {
  for (const char* text : {"[joint.b]\nviscous = 2\n[joint_default]\nviscous = 1\n",
                           "[joint_default]\nviscous = 1\n[joint.b]\nviscous = 2\n"}) {
    const ModelFolder changed = overridden(arm(""), text);
    EXPECT_EQ(changed.joints[0].viscous, 1.0);
    EXPECT_EQ(changed.joints[1].viscous, 2.0);
    EXPECT_EQ(changed.joints[2].viscous, 1.0);
  }
}

TEST(Overrides, ARecordingWithoutAWordChangesNothing) {
  const ModelFolder model = random_model(7);
  const ModelFolder same = overridden(model, "");
  EXPECT_EQ(model_toml(same), model_toml(model));
  EXPECT_TRUE(same.payloads.empty());
}

TEST(Overrides, TheActuatorAndThePeriodCanBeSaidToo) {
  const ModelFolder changed =
      overridden(arm("actuator = \"dc_servo\"\n"),
                 "[joint.c]\nactuator = \"passive\"\n[control]\nperiod_s = 0.005\n");
  EXPECT_EQ(changed.joints[2].actuator, Actuator::passive);
  EXPECT_EQ(changed.joints[0].actuator, Actuator::dc_servo);
  EXPECT_EQ(changed.period_s, 0.005);
}

TEST(Overrides, APayloadSitsWhereItsLinkIsAndOnTheBaseNowhere) {
  const ModelFolder changed =
      overridden(arm(""),
                 "[[payload]]\nlink = \"lower\"\nmass = 0.4\ncom = [0.1, 0, -0.2]\n"
                 "[[payload]]\nlink = \"base\"\nmass = 9\n");
  ASSERT_EQ(changed.payloads.size(), 1u);
  EXPECT_EQ(changed.payloads[0].joint, 1);
  EXPECT_EQ(changed.payloads[0].body.mass, 0.4);
  EXPECT_NEAR(changed.payloads[0].body.com[0], 0.1, 1e-15);
  EXPECT_THROW(overridden(arm(""), "[[payload]]\nlink = \"wing\"\nmass = 1\n"), files::InputError);
}

}  // namespace
}  // namespace sanso::diagnose
