// The library: every effect is the nominal model at its null, bit for bit, and something else at
// its probes.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "shared/files/input_error.h"
#include "tests/support/small_world.h"
#include "tests/tools/diagnose/effects/page_tables.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/effects/joint_scale.h"

namespace sanso::diagnose {
namespace {

Drive lively_drive(const ModelFolder& model) {
  Drive drive = test::make_test_drive(model, 2.0, 0.01, [](int j, double t) {
    return (j == 2 ? 0.1 : 0.6) * std::sin(5 * t + j) + (t > 1 ? 0.2 : 0.0);
  });
  for (JointData& joint : drive.joints) {
    for (double t : drive.t) joint.temp.push_back(25 + 5 * t);
  }
  return drive;
}

MeasuredMotion lively_motion(const Drive& drive) {
  MeasuredMotion motion;
  for (std::size_t j = 0; j < drive.joints.size(); ++j) {
    motion.q.emplace_back();
    motion.dq.emplace_back();
    for (double t : drive.t) {
      motion.q[j].push_back(0.3 * std::sin(5 * t));
      motion.dq[j].push_back(1.5 * std::cos(5 * t));
    }
  }
  return motion;
}

std::vector<Prediction> run(const SimParams& params, const Drive& drive,
                            const MeasuredMotion& motion) {
  const std::vector<Window> windows{{0, 120, {0.1, -0.2, 0.02}, {0.5, 0.1, 0}},
                                    {80, 200, {0.1, 0.2, 0.0}, {1, -1, 0.1}}};
  SimOptions options;
  options.motion = &motion;
  return simulate(params, drive, windows, options);
}

bool identical(const std::vector<Prediction>& a, const std::vector<Prediction>& b) {
  for (std::size_t w = 0; w < a.size(); ++w) {
    if (a[w].q != b[w].q || a[w].dq != b[w].dq || a[w].tau != b[w].tau || a[w].i != b[w].i ||
        a[w].pwm != b[w].pwm || a[w].volt != b[w].volt)
      return false;
  }
  return true;
}

const char* const kSettings =
    "armature = 0.02\nviscous = 0.05\ncoulomb = 0.04\ncurrent_limit = 2.0\n";

class EveryEffect : public testing::TestWithParam<std::string> {};

TEST_P(EveryEffect, IsTheNominalModelAtItsNull) {
  const Effect& effect = *find_effect(GetParam());
  for (const char* actuator : {"dc_servo", "position_pd", "torque"}) {
    const ModelFolder model =
        test::arm("actuator = \"" + std::string(actuator) + "\"\nkp = 12\nkd = 0.5\n" + kSettings);
    const Drive drive = lively_drive(model);
    const MeasuredMotion motion = lively_motion(drive);
    const auto nominal = run(make_params(model), drive, motion);
    for (const JointScale& scale :
         {JointScale{}, joint_scales(make_params(model), std::vector{drive})[1]}) {
      SimParams params = make_params(model);
      std::vector<double> theta;
      for (const EffectParameter& p : effect.parameters) theta.push_back(scaled(p, scale).null);
      for (int j = 0; j < 3; ++j) effect.apply(params, j, theta);
      EXPECT_TRUE(identical(run(params, drive, motion), nominal))
          << effect.id << " with " << actuator;
    }
  }
}

TEST_P(EveryEffect, ChangesThePredictionAtEveryProbe) {
  const Effect& effect = *find_effect(GetParam());
  // hot, saturated, slow and fast: every effect finds something to act on
  const ModelFolder model =
      test::arm(std::string("actuator = \"dc_servo\"\np_gain = 20\n") + kSettings);
  Drive drive = lively_drive(model);
  const MeasuredMotion motion = lively_motion(drive);
  const auto nominal = run(make_params(model), drive, motion);
  auto probes = effect.probes;
  if (probes.empty())
    // external_push has no probe of its own: its instant comes from the data
    probes = {{5, 0, 0, 0.5, 0.5}};
  for (const auto& theta : probes) {
    SimParams params = make_params(model);
    effect.apply(params, 1, theta);
    auto changed = run(params, drive, motion);
    if (effect.id == "timing_jitter") {  // changes the scatter of readings, not their mean
      auto plain = nominal;
      add_reading_jitter(params, 1, changed[0]);
      add_reading_jitter(make_params(model), 1, plain[0]);
      EXPECT_NE(changed[0].q, plain[0].q);
    } else if (effect.id == "voltage_limit" && theta[1] < kOff) {
      continue;  // the torque-speed line is for actuators without a motor model
    } else if (effect.id == "joint_stop") {
      continue;  // the motion stays inside; see JointStop.Stops
    } else {
      EXPECT_FALSE(identical(changed, nominal)) << effect.id;
    }
    for (double q : changed[1].q) ASSERT_TRUE(std::isfinite(q)) << effect.id;
  }
}

std::vector<std::string> testable_ids() {
  std::vector<std::string> ids;
  for (const Effect& e : library()) {
    if (e.apply) ids.emplace_back(e.id);
  }
  return ids;
}
INSTANTIATE_TEST_SUITE_P(Library, EveryEffect, testing::ValuesIn(testable_ids()),
                         [](const auto& p) { return p.param; });

TEST(Library, IsConsistent) {
  EXPECT_EQ(library().size(), 60u);
  std::set<std::string_view> ids;
  int simulated = 0;
  for (const Effect& e : library()) {
    EXPECT_TRUE(ids.insert(e.id).second) << e.id;
    EXPECT_EQ(static_cast<bool>(e.apply), (e.needs & (kGround | kImu)) == 0) << e.id;
    simulated += e.apply ? 1 : 0;
    for (const EffectParameter& p : e.parameters) {
      EXPECT_LE(p.low, p.null) << e.id;
      EXPECT_LE(p.null, p.high) << e.id;
      EXPECT_LT(p.low, p.high) << e.id;
      EXPECT_GT(p.typical, 0.0) << e.id;
    }
    for (const auto& theta : e.probes) {
      ASSERT_EQ(theta.size(), e.parameters.size()) << e.id;
      EXPECT_NE(theta, e.null()) << e.id;
      for (std::size_t k = 0; k < theta.size(); ++k) {
        EXPECT_LE(e.parameters[k].low, theta[k]) << e.id;
        EXPECT_LE(theta[k], e.parameters[k].high) << e.id;
      }
    }
    for (std::string_view other : e.confounders)
      EXPECT_NE(find_effect(other), nullptr) << e.id << " names " << other;
  }
  EXPECT_EQ(simulated, 49);  // 60 without 6 of the ground, 2 of the IMU, 2 of what records them
}

TEST(Library, ATwinIsListedOrContainsTheEffect) {
  EXPECT_TRUE(documented_twin("sensor_delay", "command_delay"));
  // Maxwell slip with stiff elements is dry friction, without being in the list of its look-alikes
  EXPECT_TRUE(documented_twin("maxwell_slip_friction", "coulomb_friction"));
  EXPECT_FALSE(documented_twin("link_mass", "coulomb_friction"));
  EXPECT_FALSE(documented_twin("cogging", "no_such_effect"));
  EXPECT_FALSE(documented_twin("no_such_effect", "cogging"));
  for (const Effect& e : library()) {
    EXPECT_FALSE(documented_twin(e.id, e.id)) << e.id;
    for (const std::string_view part : e.contains) {
      EXPECT_NE(find_effect(part), nullptr) << e.id << " contains " << part;
      EXPECT_TRUE(documented_twin(e.id, part)) << e.id << " contains " << part;
    }
  }
}

TEST(JointStop, Stops) {
  const ModelFolder model = test::pendulum("actuator = \"passive\"\n");
  const Drive drive = test::make_test_drive(model, 1.0, 0.005, [](int, double) { return 0.0; });
  SimParams params = make_params(model);
  find_effect("joint_stop")->apply(params, 0, std::vector<double>{200, 0.3, 1, 0.2});
  const auto out = simulate(params, drive, std::vector{test::whole(drive, {-0.8}, {0})});
  // half the swing's energy m g l (1 - cos .8) at most goes into 1/2 k x^2: x < sqrt(2 * 0.15 /
  // 200) = 0.039
  EXPECT_LT(*std::max_element(out[0].q.begin(), out[0].q.end()), 0.34);
  EXPECT_GT(*std::max_element(out[0].q.begin(), out[0].q.end()), 0.30);
}

TEST(JointStop, GivesBackWhatItDoesNotSwallow) {
  const ModelFolder model = test::pendulum("actuator = \"passive\"\n");
  const Drive drive = test::make_test_drive(model, 2.0, 0.005, [](int, double) { return 0.0; });
  for (const auto& [loss, back] : {std::pair{0.0, -0.8}, {0.4, -0.6}}) {
    SimParams params = make_params(model);
    find_effect("joint_stop")->apply(params, 0, std::vector<double>{1, 0.2, 1, loss});
    const auto out = simulate(params, drive, std::vector{test::whole(drive, {-0.8}, {0})});
    const auto after = out[0].q.begin() + 100;
    const double returned = *std::min_element(after, out[0].q.end());
    if (loss == 0.0)
      EXPECT_NEAR(returned, back, 2e-3);
    else
      EXPECT_GT(returned, back);
  }
}

TEST(EffectsOfAModel, AreCheckedAndComeBack) {
  const auto with = [](const std::string& effect) {
    return parse_model("format = 1\n[[effect]]\n" + effect, test::kArmUrdf, "model.toml");
  };
  const auto instances =
      instances_of(with("id = \"backlash\"\nwhere = [\"a\", \"b\"]\nwidth = 0.01\n"));
  ASSERT_EQ(instances.size(), 1u);
  EXPECT_EQ(instances[0].theta, (std::vector<double>{0.01, 0}));
  EXPECT_EQ(entry_of(instances[0]).parameters.at("width"), 0.01);
  const SimParams params =
      params_with_effects(with("id = \"link_mass\"\nwhere = [\"lower\"]\nshare = 0.5\n"));
  EXPECT_EQ(params.tree.joints[1].body.mass, 0.75);
  for (const char* bad :
       {"id = \"gremlins\"\n", "id = \"backlash\"\nwidth = 0.1\n",
        "id = \"backlash\"\nwhere = [\"z\"]\n", "id = \"backlash\"\nwhere = [\"a\"]\nbreadth = 1\n",
        "id = \"supply_sag\"\nwhere = [\"a\"]\n", "id = \"ground_slope\"\n"}) {
    EXPECT_THROW(instances_of(with(bad)), files::InputError) << bad;
  }
}

TEST(EffectsOfAModel, ALinksMassDoesNotScaleThePayloadOnIt) {
  ModelFolder model =
      parse_model("format = 1\n[[effect]]\nid = \"link_mass\"\nwhere = [\"lower\"]\nshare = 0.5\n",
                  test::kArmUrdf, "m");
  model.payloads.push_back({1, {2.0, {0, 0, -0.1}, {}}});
  const SimParams params = params_with_effects(model);
  EXPECT_EQ(params.tree.joints[1].body.mass, 0.75);
  ASSERT_EQ(params.late_payloads.size(), 1u);
  EXPECT_EQ(params.late_payloads[0].body.mass, 2.0);
}

/// The page with the text between <!-- begin NAME --> and <!-- end NAME --> replaced.
std::string with_section(const std::string& page, const std::string& name,
                         const std::string& text) {
  const std::string begin = "<!-- begin " + name + " -->\n", end = "<!-- end " + name + " -->";
  const auto from = page.find(begin), to = page.find(end);
  if (from == std::string::npos || to == std::string::npos) return "no section " + name;
  return page.substr(0, from + begin.size()) + text + page.substr(to);
}

TEST(ModelFolderPage, HoldsTheCurrentTables) {
  std::ifstream in("docs/model-folder.md");
  std::stringstream page;
  page << in.rdbuf();
  const std::string wanted =
      with_section(with_section(page.str(), "settings", settings_table_markdown()), "effects",
                   effect_table_markdown());
  if (std::getenv("SANSO_UPDATE_DOCS") != nullptr) std::ofstream("docs/model-folder.md") << wanted;
  EXPECT_TRUE(page.str() == wanted) << "docs/model-folder.md is not what the library says: "
                                       "run this test with SANSO_UPDATE_DOCS=1";
}

/// Largest |x| at which a payload is looked for on a rod along x: length 0.6 m, 0.3 kg, its centre
/// of mass at `com`, its inertia about that `inertia`, the next joint at `next`.
double payload_reach(double com, double inertia, double next) {
  std::ostringstream urdf;
  urdf << R"(<robot name="rod"><link name="base"/><joint name="j" type="revolute">)"
       << R"(<parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>)"
       << R"(<limit lower="-3" upper="3" effort="4" velocity="5"/></joint><link name="rod">)"
       << "<inertial><origin xyz=\"" << com << " 0 0\"/><mass value=\"0.3\"/><inertia ixx=\"0\" "
       << "ixy=\"0\" ixz=\"0\" iyy=\"" << inertia << "\" iyz=\"0\" izz=\"" << inertia
       << R"("/></inertial></link><joint name="k" type="revolute"><parent link="rod"/>)"
       << "<child link=\"tip\"/><origin xyz=\"" << next << R"( 0 0"/><axis xyz="0 1 0"/>)"
       << R"(<limit lower="-3" upper="3" effort="4" velocity="5"/></joint><link name="tip"/>)"
       << "</robot>";
  const ModelFolder model = parse_model("format = 1\n", urdf.str(), "rod/model.toml");
  const std::vector<JointScale> scales = joint_scales(make_params(model), {});
  return scaled(find_effect("payload")->parameters[1], scales[0]).high;
}

TEST(PayloadReach, IsThatOfTheLinkAndNotOfItsCentreOfMass) {
  const double length = 0.6, rod = 0.3 * length * length / 12;
  const double uniform = payload_reach(length / 2, rod, length);
  EXPECT_NEAR(uniform, 1.5 * length, 1e-9) << "half its length beyond its end";
  // a counterweight brings the centre of mass to the joint: either witness is enough
  EXPECT_NEAR(payload_reach(0.0, 4 * rod, 0.0), uniform, 1e-9) << "radius of gyration";
  EXPECT_NEAR(payload_reach(0.0, 1e-6, length), uniform, 1e-9) << "next joint";
  // a point mass at the end, nothing behind it
  EXPECT_NEAR(payload_reach(length, 0.0, 0.0), 3 * length, 1e-9);
}

TEST(JointScale, IsMeasuredByTheJointOfTheLibrary) {
  const SimParams servo = make_params(test::pendulum(
      "actuator = \"dc_servo\"\nvoltage = 12\nresistance = 5\ntorque_constant = 1.5\n"
      "back_emf = 2\n"));
  const JointScale is = joint_scales(servo, {}).front();
  LibrarySettings twice;
  for (double* figure :
       {&twice.torque, &twice.speed, &twice.inertia, &twice.current, &twice.length})
    *figure *= 2.0;
  const JointScale half = joint_scales(servo, {}, twice).front();
  for (auto part : {&JointScale::torque, &JointScale::speed, &JointScale::inertia,
                    &JointScale::current, &JointScale::length, &JointScale::reach})
    EXPECT_DOUBLE_EQ(half.*part, 0.5 * is.*part);
  EXPECT_EQ(half.angle, is.angle) << "radians are radians at any joint";
}

TEST(JointScale, ReserveCountsWhereNoDriveIsStated) {
  const SimParams free = make_params(test::pendulum("actuator = \"passive\"\n"));
  LibrarySettings library;
  const double torque = joint_scales(free, {}, library).front().torque;
  library.reserve *= 2.0;
  EXPECT_DOUBLE_EQ(joint_scales(free, {}, library).front().torque, 2.0 * torque);
}

}  // namespace
}  // namespace sanso::diagnose
