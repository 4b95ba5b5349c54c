// The two descriptions of the robot, the URDF on the host and the table on the controller, must be
// one robot.
#include "tests/oracle/urdf.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <memory>
#include <random>

#include "shared/files/input_error.h"
#include "shared/model/joints.h"
#include "tests/oracle/op3_tree.h"

namespace sanso::model {
namespace {

const std::string kData = SANSO_MODEL_DATA_DIR;

/// Place of a joint in the controller's table, -1 = not there.
int table_index(const std::string& name) {
  const auto found = std::find_if(kJoints.begin(), kJoints.end(),
                                  [&](const JointInfo& j) { return name == j.name; });
  return found == kJoints.end() ? -1 : static_cast<int>(found - kJoints.begin());
}

/// Reorders the joint part of a vector of the URDF's tree to the table's order; `head` numbers come
/// first.
TreeVector in_table_order(const UrdfRobot& robot, const TreeVector& x, int head) {
  TreeVector y = x;
  for (int i = 0; i < robot.tree.num_joints(); ++i) {
    y(head + table_index(robot.joint_names[static_cast<std::size_t>(i)])) = x(head + i);
  }
  return y;
}

TEST(Urdf, Op3IsTheRobotOfTheControllersTable) {
  const Tree table = op3_tree(nominal_parameters());
  UrdfRobot robot = read_urdf(kData + "/op3.urdf", Base::floating);
  ASSERT_EQ(robot.tree.num_joints(), kNumJoints);
  for (int i = 0; i < kNumJoints; ++i) {
    const int j = table_index(robot.joint_names[static_cast<std::size_t>(i)]);
    ASSERT_GE(j, 0) << robot.joint_names[static_cast<std::size_t>(i)];
    robot.tree.joints[static_cast<std::size_t>(i)].armature =
        table.joints[static_cast<std::size_t>(j)].armature;
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  auto sample = [&](int n) {
    TreeVector x(n);
    for (double& c : x) c = unit(random);
    return x;
  };
  auto scratch = std::make_unique<TreeScratch>();
  for (int trial = 0; trial < 100; ++trial) {
    TreeVector q = sample(robot.tree.nq());
    q.segment<4>(3).normalize();
    const TreeVector v = sample(robot.tree.nv());
    const TreeVector dv = sample(robot.tree.nv());
    TreeVector tau_urdf, tau_table;
    rnea(robot.tree, q, v, dv, *scratch, tau_urdf);
    rnea(table, in_table_order(robot, q, 7), in_table_order(robot, v, 6),
         in_table_order(robot, dv, 6), *scratch, tau_table);
    EXPECT_LT((in_table_order(robot, tau_urdf, 6) - tau_table).norm(), 1e-9 * tau_table.norm());
  }
}

TEST(Urdf, TheWholeRobotHasItsTwentyJointsAndItsWeight) {
  const UrdfRobot whole = read_urdf(kData + "/op3_full.urdf", Base::floating);
  const Tree legs = op3_tree(nominal_parameters());
  EXPECT_EQ(whole.tree.num_joints(), 20);
  auto mass = [](const Tree& tree) {
    double sum = tree.base.mass;
    for (const TreeJoint& joint : tree.joints) sum += joint.link.mass;
    return sum;
  };
  EXPECT_NEAR(mass(whole.tree), mass(legs), 1e-9);
}

/// Two links and a joint of type `type` about `axis`; a tool of 0.5 kg hangs on a fixed joint 0.2 m
/// behind.
std::string two_links(const std::string& type, const std::string& axis) {
  return "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/><origin "
         "xyz='0.1 0 0'/>"
         "<inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial></link>"
         "<link name='tool'><inertial><mass value='0.5'/>"
         "<inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' iyz='0'/></inertial></link>"
         "<joint name='j' type='" +
         type + "'><parent link='a'/><child link='b'/><axis xyz='" + axis +
         "'/>"
         "<limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
         "<joint name='w' type='fixed'><parent link='b'/><child link='tool'/><origin xyz='0.2 0 "
         "0' rpy='0 0 "
         "1.5'/></joint></robot>";
}

TEST(Urdf, JoinsWhatHangsOnFixedJoints) {
  const UrdfRobot robot = parse_urdf(two_links("revolute", "0 0 1"), "two", Base::fixed);
  ASSERT_EQ(robot.tree.num_joints(), 1);
  TreeScratch scratch;
  TreeMatrix M;
  crba(robot.tree, TreeVector::Zero(1), scratch, M);
  EXPECT_NEAR(M(0, 0), 0.01 + 1.0 * 0.1 * 0.1 + 0.5 * 0.2 * 0.2, 1e-12);
}

TEST(Urdf, PrismaticJointMovesTheMass) {
  const UrdfRobot robot = parse_urdf(two_links("prismatic", "0 0 2"), "two", Base::fixed);
  TreeScratch scratch;
  TreeMatrix M;
  crba(robot.tree, TreeVector::Zero(1), scratch, M);
  EXPECT_NEAR(M(0, 0), 1.5, 1e-12);
}

/// Simulators take a parent `world` for the fixed frame; robots are published so.
TEST(Urdf, AParentWorldNeedNotBeDeclared) {
  std::string text = two_links("revolute", "0 0 1");
  const std::string weld =
      "<joint name='weld' type='fixed'><parent link='world'/><child link='a'/></joint>";
  text.insert(text.find("<joint"), weld);
  const UrdfRobot robot = parse_urdf(text, "welded", Base::fixed);
  ASSERT_EQ(robot.tree.num_joints(), 1);
  EXPECT_EQ(robot.joint_names.front(), "j");
  text.replace(text.find("'world'"), 7, "'floor'");
  EXPECT_THROW(parse_urdf(text, "unknown", Base::fixed), files::InputError);
}

TEST(Urdf, RefusesByName) {
  auto defect = [](const std::string& text) {
    try {
      parse_urdf(text, "bad.urdf", Base::fixed);
    } catch (const files::InputError& error) {
      EXPECT_EQ(error.file, "bad.urdf");
      return error.defect;
    }
    return std::string("accepted");
  };
  EXPECT_EQ(defect("<robot"), "not a URDF");
  EXPECT_EQ(defect("<robot name='r'><link name='a'/></robot>"), "no movable joint");
  EXPECT_EQ(defect(two_links("planar", "0 0 1")), "joint type not supported");
  EXPECT_EQ(defect(two_links("revolute", "0 0 0")), "axis of no length");
  EXPECT_THROW(read_urdf("/no/such/file.urdf", Base::fixed), files::InputError);
}

}  // namespace
}  // namespace sanso::model
