// Models in the formats of others: read by MuJoCo, urdfdom and sdformat, predicted by MuJoCo, and
// every effect of the library either held or said to be lost.
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <random>

#include "tests/support/mujoco_model.h"
#include "tests/support/small_world.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/formats/formats.h"

#if SANSO_SDFORMAT
#include <sdf/sdf.hh>
#endif

namespace sanso::diagnose {
namespace {

using Writer = Exported (*)(const ModelFolder&);
const std::vector<std::pair<const char*, Writer>> kWriters{
    {"MJCF", mjcf_of}, {"URDF", urdf_of}, {"SDF", sdf_of}};

std::string without_comment(const std::string& text) { return text.substr(text.find("-->")); }

EffectEntry entry(const std::string& id, const std::string& where,
                  std::map<std::string, double> parameters) {
  return {id, where.empty() ? std::vector<std::string>{} : std::vector{where},
          std::move(parameters), 0};
}

ModelFolder with(ModelFolder model, std::vector<EffectEntry> effects) {
  return test::hiding(std::move(model), effects);
}

/// A model of every kind of actuator and joint, with effects that MJCF holds.
std::vector<test::SmallWorld> rich_models() {
  const std::string stated = "armature = 0.02\nviscous = 0.05\ncoulomb = 0.04\n";
  return {
      {"servo", with(test::pendulum("actuator = \"dc_servo\"\ntorque_limit = 0\n" + stated),
                     {entry("cable_spring", "a", {{"stiffness", 0.4}, {"torque", 0.2}}),
                      entry("servo_p_gain", "a", {{"gain", 0.6}}),
                      entry("torque_constant", "a", {{"torque", 0.9}, {"resistance", 1.2}}),
                      entry("servo_d_gain", "a", {{"damping", 0.1}}),
                      entry("voltage_limit", "a", {{"limit", 0.5}}),
                      entry("battery_drift", "", {{"level", -0.1}}),
                      entry("payload", "arm", {{"mass", 0.1}, {"z", -0.1}, {"x", 0.03}})})},
      {"torque", with(test::two_links("actuator = \"torque\"\ntorque_limit = 2\n" + stated),
                      {entry("link_mass", "lower", {{"share", 0.3}}),
                       entry("link_com", "upper", {{"x", 0.02}}),
                       entry("link_geometry", "b", {{"length", 0.004}, {"tilt_1", 0.03}}),
                       entry("rotor_inertia", "b", {{"armature", 0.01}})})},
      {"position", test::slider("actuator = \"position_pd\"\nkp = 300\nkd = 15\ntorque_limit = 6\n"
                                "armature = 0.2\nviscous = 0.5\ncoulomb = 0.4\n")},
      {"arm",
       test::arm("actuator = \"position_pd\"\nkp = 40\nkd = 2\ntorque_limit = 0\n" + stated)},
  };
}

double command(int joint, double t) { return 0.7 * std::sin((4.0 + joint) * t) + 0.1 * joint; }

TEST(Formats, MuJoCoPredictsTheMjcfAsOurSimulatorPredictsTheModel) {
  constexpr double kShare = 0.004;  // of the range of the motion: docs/howto/see.md says so
  for (const auto& [name, model] : rich_models()) {
    SCOPED_TRACE(name);
    const Drive drive = test::make_test_drive(model, 3.0, 0.01, command);
    const std::size_t n = model.tree.size();
    const auto ours =
        simulate(params_with_effects(model), drive,
                 std::vector{test::whole(drive, std::vector(n, 0.0), std::vector(n, 0.0))});
    sanso::testing::Mujoco mujoco(mjcf_of(model).text);
    ASSERT_EQ(mujoco.model->nu, static_cast<int>(n));
    const int steps = static_cast<int>(std::lround(0.01 / mujoco.model->opt.timestep));
    for (std::size_t j = 0; j < n; ++j) {
      mj_resetData(mujoco.model.get(), mujoco.data.get());
      double low = 0, high = 0, worst = 0;
      for (std::size_t r = 0; r + 1 < drive.rows(); ++r) {
        const double q = ours[0].of(ours[0].q, j)[r];
        low = std::min(low, q), high = std::max(high, q);
        worst = std::max(worst, std::abs(q - mujoco.data->qpos[j]));
        for (std::size_t k = 0; k < n; ++k) mujoco.data->ctrl[k] = drive.joints[k].command[r];
        for (int s = 0; s < steps; ++s) mj_step(mujoco.model.get(), mujoco.data.get());
      }
      EXPECT_GT(high - low, 0.02) << "it moves";
      EXPECT_LT(worst, kShare * (high - low)) << "joint " << j << ", range " << high - low;
    }
  }
}

/// The mass matrix at q as MuJoCo has it.
std::vector<double> mass_matrix(sanso::testing::Mujoco& mujoco, const std::vector<double>& q) {
  const auto n = static_cast<std::size_t>(mujoco.model->nv);
  std::copy(q.begin(), q.end(), mujoco.data->qpos);
  mj_forward(mujoco.model.get(), mujoco.data.get());
  std::vector<double> full(n * n);
  mj_fullM(mujoco.model.get(), full.data(), mujoco.data->qM);
  for (std::size_t i = 0; i < n; ++i) full[i * n + i] -= mujoco.model->dof_armature[i];
  return full;
}

TEST(Formats, TheUrdfHasTheMassMatrixAndTheWeightOfTheMjcf) {
  std::mt19937 random(3);
  for (const auto& [name, model] : rich_models()) {
    SCOPED_TRACE(name);
    sanso::testing::Mujoco as_mjcf(mjcf_of(model).text);
    std::string urdf = urdf_of(model).text;
    urdf.insert(urdf.find("<link"),
                "<mujoco><compiler balanceinertia=\"false\" "
                "boundmass=\"1e-9\" boundinertia=\"1e-12\"/></mujoco>\n");
    sanso::testing::Mujoco as_urdf(urdf);
    ASSERT_EQ(as_urdf.model->nv, as_mjcf.model->nv);
    for (int k = 0; k < 5; ++k) {
      std::vector<double> q(static_cast<std::size_t>(as_mjcf.model->nv));
      for (double& v : q) v = std::uniform_real_distribution<>(-0.9, 0.9)(random);
      const std::vector<double> a = mass_matrix(as_mjcf, q), b = mass_matrix(as_urdf, q);
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-7 + 1e-6 * a[i]);
      for (int i = 0; i < as_mjcf.model->nv; ++i)
        EXPECT_NEAR(as_mjcf.data->qfrc_bias[i], as_urdf.data->qfrc_bias[i], 1e-5);
    }
    for (int i = 0; i < as_mjcf.model->nv; ++i)
      EXPECT_NEAR(as_mjcf.model->dof_frictionloss[i], as_urdf.model->dof_frictionloss[i], 1e-12);
  }
}

// fixed links, shapes of every kind, a mesh, a joint and a link of one name
constexpr const char* kFurnished = R"(<robot name="furnished">
<link name="base"><visual><geometry><box size="0.1 0.2 0.3"/></geometry></visual></link>
<joint name="arm" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="2" effort="3" velocity="4"/></joint>
<link name="arm"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0"
izz="0.01"/></inertial><visual><origin xyz="0.1 0 0" rpy="0 1.5707963 0"/><geometry>
<cylinder radius="0.02" length="0.2"/></geometry></visual></link>
<joint name="tip_joint" type="fixed"><parent link="arm"/><child link="tip"/>
<origin xyz="0.2 0 0" rpy="0.4 0 0.3"/></joint>
<link name="tip"><inertial><mass value="0.5"/><inertia ixx="0.002" ixy="0" ixz="0" iyy="0.001"
iyz="0" izz="0.001"/></inertial><visual><geometry><sphere radius="0.03"/></geometry></visual>
<visual><geometry><mesh filename="package://robot/tip.stl"/></geometry></visual></link></robot>)";

ModelFolder furnished() {
  return test::small_model("actuator = \"passive\"\nviscous = 0.1\n", kFurnished, "furnished");
}

TEST(Formats, ReadBackByOurReaderAUrdfIsTheSameTree) {
  for (const ModelFolder& model : {furnished(), test::arm("actuator = \"torque\"\n")}) {
    const RobotTree again = tree_from_urdf(urdf_of(model).text, "again");
    ASSERT_EQ(again.size(), model.tree.size());
    for (std::size_t i = 0; i < again.joints.size(); ++i) {
      const TreeJoint &a = again.joints[i], &b = model.tree.joints[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_NEAR(a.body.mass, b.body.mass, 1e-12);
      for (std::size_t k = 0; k < 9; ++k) {
        EXPECT_NEAR(a.R_parent_joint[k], b.R_parent_joint[k], 1e-12);
        EXPECT_NEAR(a.body.about_com[k], b.body.about_com[k], 1e-12);
      }
      EXPECT_EQ(a.lower, b.lower);
      EXPECT_EQ(a.upper, b.upper);
    }
    ASSERT_EQ(again.links.size(), model.tree.links.size());
    for (const auto& [name, place] : model.tree.links) {
      ASSERT_EQ(again.links.count(name), 1u) << name;
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(again.links.at(name).p_joint_link[k], place.p_joint_link[k], 1e-12);
    }
  }
}

TEST(Formats, ShapesStayAndMeshesAreSaidToBeLost) {
  const Exported mjcf = mjcf_of(furnished());
  const sanso::testing::Mujoco mujoco(mjcf.text);
  EXPECT_EQ(mujoco.model->ngeom, 3);
  EXPECT_NE(mjcf.text.find("meshes"), std::string::npos);
  const auto read = urdf::parseURDF(urdf_of(furnished()).text);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->getLink("arm")->visual_array.size(), 3u);
  EXPECT_DOUBLE_EQ(read->getJoint("arm")->dynamics->damping, 0.1);
}

/// Somewhere on the robot, at a probe of the library.
EffectEntry probe_of(const Effect& effect, const ModelFolder& model) {
  EffectInstance instance{&effect, {}, effect.null()};
  const TreeJoint& joint = model.tree.joints.back();
  if (effect.scope == Scope::joint) instance.where = {joint.name};
  if (effect.scope == Scope::link) instance.where = {joint.link};
  if (effect.probes.empty())
    instance.theta[0] += effect.parameters[0].typical;
  else
    instance.theta = effect.probes.front();
  return entry_of(instance);
}

TEST(Formats, EveryEffectOfTheLibraryIsHeldOrSaidToBeLost) {
  const ModelFolder models[] = {test::two_links("actuator = \"dc_servo\"\n"),
                                test::two_links("actuator = \"position_pd\"\nkp = 10\n")};
  for (const auto& [format, write] : kWriters)
    for (const Effect& effect : library()) {
      if (!effect.apply) continue;
      bool held = false, said = false;
      for (const ModelFolder& model : models) {
        const Exported plain = write(model);
        const Exported changed = write(with(model, {probe_of(effect, model)}));
        held = held || without_comment(plain.text) != without_comment(changed.text);
        said = said || plain.lost != changed.lost;
        for (const std::string& sentence : changed.lost)
          EXPECT_NE(changed.text.find(sentence), std::string::npos) << "in the file too";
      }
      // the drive as a whole is said to be lost where there is none
      const bool no_drive = std::string_view(format) != "MJCF" &&
                            (effect.port == Port::firmware || effect.port == Port::electrical ||
                             effect.id == "rotor_inertia");
      EXPECT_TRUE(held || said || no_drive) << format << " forgets " << effect.id;
    }
}

TEST(Formats, AFloatingBaseIsRefused) {
  const ModelFolder model =
      parse_model("format = 1\n[robot]\nbase = \"floating\"\n[ground]\nkind = \"plane\"\n",
                  test::kPendulumUrdf, "floating/model.toml");
  for (const auto& [format, write] : kWriters)
    EXPECT_THROW((void)write(model), std::exception) << format;
}

#if SANSO_SDFORMAT
TEST(Formats, TheReaderOfSdfFindsNothingWrongAndTheSameBodies) {
  std::vector<test::SmallWorld> models = rich_models();
  models.push_back({"furnished", furnished()});
  for (const auto& [name, model] : models) {
    SCOPED_TRACE(name);
    sdf::Root root;
    const sdf::Errors errors = root.LoadSdfString(sdf_of(model).text);
    for (const sdf::Error& error : errors) ADD_FAILURE() << error.Message();
    ASSERT_NE(root.Model(), nullptr);
    const RobotTree tree = params_with_effects(model).tree;
    double mass = 0, expected = 0;
    for (const TreeJoint& joint : tree.joints) {
      const sdf::Link* link = root.Model()->LinkByName(joint.link);
      ASSERT_NE(link, nullptr) << joint.link;
      mass += link->Inertial().MassMatrix().Mass();
      expected += joint.body.mass;
      ignition::math::Pose3d pose;
      const std::string parent =
          joint.parent < 0 ? "base" : tree.joints[static_cast<std::size_t>(joint.parent)].link;
      EXPECT_TRUE(link->SemanticPose().Resolve(pose, parent).empty());
      EXPECT_NEAR(pose.Pos().Z(), joint.p_parent_joint[2], 1e-9);
      EXPECT_NEAR(pose.Pos().Y(), joint.p_parent_joint[1], 1e-9);
    }
    if (name == "servo") expected += 0.1;  // the payload that is on from the beginning
    EXPECT_NEAR(mass, expected, 1e-9);
    const sdf::Joint* last = root.Model()->JointByIndex(root.Model()->JointCount() - 1);
    ASSERT_NE(last->Axis(), nullptr);
    EXPECT_GT(last->Axis()->Damping(), 0.0);
  }
}
#endif

}  // namespace
}  // namespace sanso::diagnose
