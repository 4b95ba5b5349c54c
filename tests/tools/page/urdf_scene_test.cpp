// What the page is told of a URDF: every link under its parent, shapes as they stand there, meshes
// from the files beside it, and a word for what cannot be drawn.
#include "tools/page/embedded/urdf_scene.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "shared/files/input_error.h"
#include "tests/support/temp_folder.h"

namespace sanso::page {
namespace {

using nlohmann::json;

constexpr char kUrdf[] = R"(<robot name="r">
<link name="base"><visual><geometry><box size="0.1 0.2 0.3"/></geometry></visual></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/>
<origin xyz="0 0 0.5" rpy="0 1.5707963267948966 0"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<link name="arm"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><origin xyz="0.2 0 0"/><geometry><cylinder radius="0.02" length="0.4"/></geometry>
</collision></link>
<joint name="bolt" type="fixed"><parent link="arm"/><child link="hand"/></joint>
<link name="hand"><visual><geometry><mesh filename="package://robot_description/meshes/hand.STL"
scale="0.001 0.001 0.001"/></geometry></visual></link>
<joint name="slide" type="prismatic"><parent link="hand"/><child link="finger"/>
<axis xyz="1 0 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<link name="finger"><visual><geometry><mesh filename="finger.dae"/></geometry></visual></link>
</robot>)";

const json& link(const json& scene, const std::string& name) {
  for (const json& l : scene.at("links"))
    if (l.at("name") == name) return l;
  throw std::out_of_range(name);
}

class UrdfScene : public testing::Test {
 protected:
  void write_mesh(const std::string& bytes) const {
    std::filesystem::create_directories(folder_.path() / "meshes");
    std::ofstream(folder_.path() / "meshes" / "hand.STL", std::ios::binary) << bytes;
  }
  json scene(std::size_t most = 1000) const {
    return scene_of_urdf(kUrdf, "robot.urdf", folder_.path(), most);
  }
  sanso::test::TempFolder folder_;
};

TEST_F(UrdfScene, HoldsEveryLinkAfterItsParent) {
  const json s = scene();
  ASSERT_EQ(s.at("links").size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(s.at("links")[i].at("parent").get<int>(), int(i));
  EXPECT_EQ(link(s, "base").at("parent"), -1);
  EXPECT_EQ(link(s, "base").count("joint"), 0u);
  EXPECT_EQ(link(s, "hand").count("joint"), 0u) << "a bolt does not move";
  EXPECT_EQ(link(s, "arm").at("joint").at("name"), "turn");
  EXPECT_EQ(link(s, "arm").at("joint").at("slides"), false);
  EXPECT_EQ(link(s, "finger").at("joint").at("slides"), true);
  EXPECT_EQ(link(s, "arm").at("pos"), json({0.0, 0.0, 0.5}));
  EXPECT_NEAR(link(s, "arm").at("quat")[0].get<double>(), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(link(s, "arm").at("quat")[2].get<double>(), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(link(s, "arm").at("com"), json({0.1, 0.0, 0.0}));
}

TEST_F(UrdfScene, ShapesAreThoseOfTheUrdf) {
  const json s = scene();
  EXPECT_EQ(link(s, "base").at("shapes")[0].at("size"), json({0.1, 0.2, 0.3}));
  const json& rod = link(s, "arm").at("shapes")[0];  // has no visual
  EXPECT_EQ(rod.at("length"), 0.4);
  EXPECT_EQ(rod.at("pos"), json({0.2, 0.0, 0.0}));
}

TEST_F(UrdfScene, MeshesAreFoundBesideIt_OrSaidToBeMissing) {
  EXPECT_EQ(scene().at("notes").size(), 2u) << "one is not there, one is no STL";
  write_mesh("abc");
  const json s = scene();
  EXPECT_EQ(link(s, "hand").at("shapes")[0].at("stl"), "YWJj");
  EXPECT_EQ(link(s, "hand").at("shapes")[0].at("scale")[0], 0.001);
  EXPECT_EQ(s.at("notes").size(), 1u);
  write_mesh(std::string(1001, 'x'));
  EXPECT_TRUE(link(scene(), "hand").at("shapes").empty()) << "too large";
}

TEST_F(UrdfScene, WhatIsNoUrdfIsAnError) {
  EXPECT_THROW((void)scene_of_urdf("<robot", "robot.urdf", folder_.path()), files::InputError);
}

}  // namespace
}  // namespace sanso::page
