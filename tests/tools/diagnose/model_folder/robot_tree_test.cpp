// Bodies, frames and trees: laws of rigid mass, what merging fixed joints must keep, what is
// refused.
#include "tools/diagnose/model_folder/robot_tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/files/input_error.h"
#include "tools/diagnose/model_folder/body_tree.h"
#include "tools/diagnose/model_folder/joint_units.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

Mat3 about_z(double a) {
  return {std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1};
}
Mat3 about_x(double a) {
  return {1, 0, 0, 0, std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a)};
}

BodyInertia random_body(Random& random) {
  BodyInertia b{0.1 + random.uniform(), {random.normal(), random.normal(), random.normal()}, {}};
  // a cloud of points has an inertia that a real body can have
  for (int k = 0; k < 6; ++k) {
    BodyInertia point{0.1, {b.com[0] + random.normal(), b.com[1] + random.normal(), b.com[2]}, {}};
    add_body(b, point);
  }
  return b;
}

void expect_same(const BodyInertia& a, const BodyInertia& b) {
  EXPECT_NEAR(a.mass, b.mass, 1e-12);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(a.com[k], b.com[k], 1e-12);
  for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(a.about_com[k], b.about_com[k], 1e-11);
}

TEST(BodyInertia, AddingDoesNotDependOnTheOrder) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const BodyInertia a = random_body(random), b = random_body(random), c = random_body(random);
    BodyInertia left = a, right = c;
    add_body(left, b), add_body(left, c);
    add_body(right, b), add_body(right, a);
    expect_same(left, right);
  }
}

TEST(BodyInertia, AddingAndThenMovingIsMovingAndThenAdding) {
  Random random(2);
  const Mat3 R = product(about_z(0.7), about_x(-1.1));
  const Vec3 p{0.3, -0.2, 0.9};
  for (int trial = 0; trial < 20; ++trial) {
    BodyInertia together = random_body(random);
    const BodyInertia other = random_body(random);
    BodyInertia apart = moved(together, R, p);
    add_body(together, other);
    add_body(apart, moved(other, R, p));
    expect_same(moved(together, R, p), apart);
  }
}

TEST(BodyInertia, MovingKeepsMassAndPrincipalMoments) {
  Random random(3);
  const BodyInertia b = random_body(random);
  const BodyInertia m = moved(b, product(about_x(0.4), about_z(2.0)), {1, 2, 3});
  EXPECT_EQ(m.mass, b.mass);
  const auto trace = [](const Mat3& I) { return I[0] + I[4] + I[8]; };
  EXPECT_NEAR(trace(m.about_com), trace(b.about_com), 1e-12);
  EXPECT_NEAR(trace(product(m.about_com, m.about_com)), trace(product(b.about_com, b.about_com)),
              1e-11);
  for (const auto& [i, j] : {std::pair{1, 3}, {2, 6}, {5, 7}})
    EXPECT_NEAR(m.about_com[static_cast<std::size_t>(i)], m.about_com[static_cast<std::size_t>(j)],
                1e-12);
}

TEST(BodyInertia, TwoPointsAreADumbbell) {
  BodyInertia b{1.0, {0.3, 0, 0}, {}};
  add_body(b, {2.0, {-0.3, 0, 0}, {}});
  EXPECT_NEAR(b.com[0], -0.1, 1e-15);
  EXPECT_NEAR(b.about_com[0], 0.0, 1e-15);
  EXPECT_NEAR(b.about_com[4], 2.0 / 3.0 * 0.36, 1e-12);
}

TEST(BodyInertia, NothingAddedToNothingIsNothing) {
  BodyInertia b;
  add_body(b, BodyInertia{});
  EXPECT_EQ(b.mass, 0.0);
  const BodyInertia one{2.0, {1, 0, 0}, {}};
  BodyInertia sum;
  add_body(sum, one);
  expect_same(sum, one);
}

TEST(Mat3, ProductRotatesOneAfterTheOther) {
  const Mat3 A = about_z(0.3), B = about_x(1.2);
  const Vec3 v{0.1, 0.2, -0.7}, once = rotated(product(A, B), v), twice = rotated(A, rotated(B, v));
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(once[k], twice[k], 1e-15);
  const Mat3 none = product(about_z(0.5), about_z(-0.5));
  for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(none[k], kIdentity3[k], 1e-15);
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& inside = "<axis xyz=\"0 0 1\"/>") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + inside +
         "<limit lower=\"-1\" upper=\"2\" effort=\"3\" velocity=\"4\"/></joint>";
}
std::string link(const std::string& name, const std::string& mass = "1") {
  return "<link name=\"" + name + "\"><inertial><origin xyz=\"0 0 0.1\"/><mass value=\"" + mass +
         "\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>" +
         "</link>";
}
RobotTree tree(const std::string& inside) {
  return tree_from_urdf("<robot name=\"r\">" + inside + "</robot>", "robot.urdf");
}

TEST(RobotTree, ParentsStandBeforeTheirChildrenAndNamesFindThem) {
  const RobotTree t =
      tree("<link name=\"base\"/>" + link("l1") + link("l2") + link("r1") +
           joint("tip", "continuous", "l1", "l2") + joint("left", "revolute", "base", "l1") +
           joint("right", "prismatic", "base", "r1"));
  ASSERT_EQ(t.size(), 3u);
  for (int j = 0; j < 3; ++j) EXPECT_LT(t.joints[static_cast<std::size_t>(j)].parent, j);
  const auto& tip = t.joints[static_cast<std::size_t>(t.index_of("tip"))];
  EXPECT_EQ(tip.parent, t.index_of("left"));
  EXPECT_EQ(tip.link, "l2");
  EXPECT_EQ(t.index_of("nobody"), -1);
  EXPECT_EQ(t.joints[static_cast<std::size_t>(t.index_of("right"))].parent, -1);
}

TEST(RobotTree, OnlyJointsWithLimitsHaveThem) {
  const RobotTree t =
      tree("<link name=\"base\"/>" + link("l1") + link("l2") +
           joint("turns", "continuous", "base", "l1") + joint("bends", "revolute", "l1", "l2"));
  EXPECT_EQ(t.joints[0].lower, t.joints[0].upper);
  EXPECT_EQ(t.joints[1].lower, -1.0);
  EXPECT_EQ(t.joints[1].upper, 2.0);
  EXPECT_EQ(t.joints[0].effort, 3.0);
  EXPECT_EQ(t.joints[1].speed, 4.0);
}

TEST(RobotTree, LinksMergedAwayKeepTheirPlace) {
  const RobotTree t = tree("<link name=\"base\"/>" + link("l1") + link("tool") +
                           joint("j", "continuous", "base", "l1") +
                           joint("weld", "fixed", "l1", "tool",
                                 "<origin xyz=\"0.1 0.2 0.3\" rpy=\"0 0 1.5707963267948966\"/>"));
  ASSERT_EQ(t.size(), 1);
  const LinkPlace& place = t.links.at("tool");
  EXPECT_EQ(place.joint, 0);
  EXPECT_NEAR(place.p_joint_link[1], 0.2, 1e-15);
  EXPECT_NEAR(rotated(place.R_joint_link, {1, 0, 0})[1], 1.0, 1e-12);
  EXPECT_EQ(t.links.at("base").joint, -1);
  EXPECT_NEAR(t.joints[0].body.mass, 2.0, 1e-15);
}

TEST(RobotTree, WhatIsFixedToTheBaseWeighsOnNoJoint) {
  const RobotTree t =
      tree("<link name=\"base\"/>" + link("stand", "50") + link("l1") +
           joint("bolt", "fixed", "base", "stand") + joint("j", "continuous", "stand", "l1"));
  EXPECT_EQ(t.joints[0].body.mass, 1.0);
  EXPECT_EQ(t.links.at("stand").joint, -1);
}

TEST(RobotTree, RefusesByNameWhatItCannotSimulate) {
  struct Case {
    std::string urdf;
    const char *where, *defect;
  };
  const std::string start = "<link name=\"base\"/>" + link("l1");
  for (const Case& c :
       {Case{start + joint("f", "floating", "base", "l1"), "f", "joint type not supported"},
        Case{start + joint("a", "continuous", "base", "l1", "<axis xyz=\"0 0 0\"/>"), "a",
             "axis of no length"},
        Case{"<link name=\"base\"/>" + link("l1", "-2") + joint("a", "continuous", "base", "l1"),
             "l1", "impossible inertia"}}) {
    try {
      tree(c.urdf);
      FAIL() << c.defect;
    } catch (const files::InputError& e) {
      EXPECT_EQ(e.defect, c.defect) << e.what();
      EXPECT_EQ(e.channel, c.where) << e.what();
      EXPECT_EQ(e.file, "robot.urdf");
    }
  }
}

TEST(RobotTree, TakesTwentyJointsAndNotOneMore) {
  const auto chain = [](int n) {
    std::string text = "<link name=\"l0\"/>";
    for (int k = 1; k <= n; ++k) {
      text += link("l" + std::to_string(k));
      text += joint("j" + std::to_string(k), "continuous", "l" + std::to_string(k - 1),
                    "l" + std::to_string(k));
    }
    return text;
  };
  EXPECT_EQ(tree(chain(kMaxJoints)).size(), kMaxJoints);
  EXPECT_THROW(tree(chain(kMaxJoints + 1)), files::InputError);
}

TEST(JointUnits, OfASlidingJointAreLengthsAndForces) {
  for (const auto& [turns, slides] : {std::pair{"rad", "m"},
                                      {"rad/s", "m/s"},
                                      {"N m", "N"},
                                      {"kg m^2", "kg"},
                                      {"missing torque [N m]", "missing force [N]"},
                                      {"A", "A"}}) {
    EXPECT_EQ(at_joint(turns, true), slides);
    EXPECT_EQ(at_joint(turns, false), turns);
  }
}

TEST(JointUnits, AnEffortIsToldInTheUnitInWhichItWasRecorded) {
  EXPECT_EQ(with_effort_in("N m", "A"), "A");
  EXPECT_EQ(with_effort_in("N m s/rad", "A"), "A s/rad");
  EXPECT_EQ(with_effort_in("N s/m", "%"), "% s/m");
  EXPECT_EQ(with_effort_in("rad/(N m)", "A"), "rad/(A)");
  EXPECT_EQ(with_effort_in("-", "A"), "-");
}

TEST(CylinderRims, LieOnTheCylinderEvenlyAndAsManyAsAsked) {
  for (const int points : {3, 6, 12, 25}) {
    const std::vector<Vec3> rims = cylinder_rims(0.2, 0.6, points);
    ASSERT_EQ(rims.size(), 2U * static_cast<std::size_t>(points));
    Vec3 sum{0, 0, 0};
    for (const Vec3& p : rims) {
      EXPECT_NEAR(std::hypot(p[0], p[1]), 0.2, 1e-12);
      EXPECT_NEAR(std::abs(p[2]), 0.3, 1e-12);
      for (std::size_t i = 0; i < 3; ++i) sum[i] += p[i];
    }
    for (const double s : sum) EXPECT_NEAR(s, 0.0, 1e-12) << points;
    const BodyTree tree = body_tree_from_urdf(
        R"(<robot name="can"><link name="can"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial><collision>
<geometry><cylinder radius="0.2" length="0.6"/></geometry></collision></link></robot>)",
        "can.urdf", points);
    EXPECT_EQ(tree.shapes.front().points, rims);
  }
}

}  // namespace
}  // namespace sanso::diagnose
