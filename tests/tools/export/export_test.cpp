// What is exported, read back by readers that others wrote or that stand elsewhere in this tree.
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <cstdlib>
#include <filesystem>

#include "shared/model/joints.h"
#include "tools/export/op3_urdf.h"
#include "tools/export/trial_mcap.h"
#include "tools/plant/body_data.h"
#include "tools/recording/mcap_recording.h"

namespace sanso::exports {
namespace {

namespace fs = std::filesystem;

TEST(Op3Urdf, IsTheMakersRobotToTheParserOfRos) {
  const urdf::ModelInterfaceSharedPtr robot = urdf::parseURDF(op3_urdf());
  ASSERT_TRUE(robot);
  double mass = 0, expected = 0;
  for (const auto& [name, link] : robot->links_)
    mass += link->inertial ? link->inertial->mass : 0.0;
  for (const plant::LinkData& link : plant::op3_body().links) expected += link.mass_kg;
  EXPECT_NEAR(mass, expected, 1e-9);
  EXPECT_EQ(robot->getRoot()->name, "base_link");
  for (const plant::JointData& joint : plant::op3_body().joints) {
    const auto read = robot->getJoint(joint.name);
    ASSERT_TRUE(read) << joint.name;
    EXPECT_EQ(read->parent_link_name, joint.parent);
    EXPECT_DOUBLE_EQ(read->parent_to_joint_origin_transform.position.z, joint.origin_m[2]);
    EXPECT_DOUBLE_EQ(read->axis.y, joint.axis[1]);
  }
}

TEST(Op3Urdf, LetsTheControllerGoWhereItMayGo) {
  const urdf::ModelInterfaceSharedPtr robot = urdf::parseURDF(op3_urdf());
  ASSERT_TRUE(robot);
  for (const model::JointInfo& joint : model::kJoints) {
    const auto read = robot->getJoint(joint.name);
    ASSERT_TRUE(read && read->limits) << joint.name;
    EXPECT_LE(read->limits->lower, joint.lower_rad) << joint.name;
    EXPECT_GE(read->limits->upper, joint.upper_rad) << joint.name;
  }
}

TEST(Op3Urdf, EveryFootAndThighCanBeSeen) {
  const urdf::ModelInterfaceSharedPtr robot = urdf::parseURDF(op3_urdf());
  ASSERT_TRUE(robot);
  for (const char* name :
       {"body_link", "r_hip_pitch_link", "l_hip_pitch_link", "r_ank_roll_link", "l_ank_roll_link"})
    EXPECT_TRUE(robot->getLink(name)->visual) << name;
}

struct TrialMcap : testing::Test {
  fs::path folder;
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "sanso_export_XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder); }
};

TEST_F(TrialMcap, IsARecordingWithTheAnglesOfTheTrial) {
  learn::Episode episode;
  constexpr int kTicks = 50;
  for (int k = 0; k < kTicks; ++k) {
    wire::Observation o;
    o.trial_tick = k;
    o.time = (100 + k) * kTickPeriod;
    o.x[model::kXJoint + 3] = 0.01 * k;
    o.u_out[3] = 0.02 * k;
    episode.ticks.push_back(o);
  }
  (void)write_trial_mcap(episode, folder / "a.mcap");
  const recording::Recording read = recording::read_recording((folder / "a.mcap").string());
  ASSERT_EQ(read.t.size(), std::size_t{kTicks});
  const std::span<const double> q = read.find("q:r_knee"), u = read.find("u:r_knee");
  ASSERT_EQ(q.size(), read.t.size());
  ASSERT_EQ(u.size(), read.t.size());
  for (std::size_t k = 0; k < read.t.size(); ++k) {
    EXPECT_DOUBLE_EQ(q[k], 0.01 * static_cast<double>(k));
    EXPECT_DOUBLE_EQ(u[k], 0.02 * static_cast<double>(k));
  }
}

TEST_F(TrialMcap, ATrialWithoutATickIsRefusedAndLeavesNoFile) {
  learn::Episode episode;
  episode.end = learn::TrialEnd::fell_before;
  try {
    (void)write_trial_mcap(episode, folder / "b.mcap");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("fell before"), std::string::npos);
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

}  // namespace
}  // namespace sanso::exports
