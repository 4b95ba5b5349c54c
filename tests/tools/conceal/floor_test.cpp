// A robot on a floor: what is hidden is what the recordings show, what is not hidden is a
// tolerance, and files are what was made.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/temp_folder.h"
#include "tools/conceal/floor_case.h"
#include "tools/conceal/floor_effects.h"
#include "tools/conceal/seal.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/wholebody/whole_data.h"
#include "tools/plant/world_error.h"
#include "tools/recording/csv_reader.h"

namespace sanso::conceal {
namespace {

using nlohmann::json;
using recording::Recording;

constexpr double kG = 9.81;

double mean(const Recording& r, const std::string& name) {
  const auto column = r.find(name);
  EXPECT_FALSE(column.empty()) << name;
  double sum = 0.0;
  for (const double v : column) sum += v;
  return sum / static_cast<double>(column.size());
}

Vec3 mean3(const Recording& r, const std::string& kind) {
  return {mean(r, kind + ":x"), mean(r, kind + ":y"), mean(r, kind + ":z")};
}

/// Sum of the feet's forces, mean over the recording, N.
double carried(const Recording& r) {
  double sum = 0.0;
  for (const recording::Channel& c : r.channels)
    if (c.name.starts_with("fz:")) sum += mean(r, c.name);
  return sum;
}

double mass_of(const FloorTruth& truth) {
  double sum = truth.trunk.mass + truth.payload_kg;
  for (const LinkSpec& l : truth.legs.links) sum += l.mass;
  return sum;
}

FloorMotion stand(double heading = 0.0) {
  FloorMotion m;
  m.name = "rec", m.condition = "stand", m.heading = heading;
  return m;
}

TEST(FloorWorld, FeetCarryWhatTheRobotWeighs) {
  FloorTruth truth = nominal_floor();
  const double weight = carried(run_on_floor(truth, stand(), 1));
  EXPECT_NEAR(weight, mass_of(truth) * kG, 0.01 * weight);
  truth.payload_kg = 0.5;
  const double loaded = carried(run_on_floor(truth, stand(), 1));
  EXPECT_NEAR(loaded - weight, 0.5 * kG, 0.002 * weight);
  truth.force_scale = 1.1;
  EXPECT_NEAR(carried(run_on_floor(truth, stand(), 1)), 1.1 * loaded, 0.002 * weight);
}

TEST(FloorWorld, SensorsReadWhatTheyAreSpoiledBy) {
  FloorTruth truth = nominal_floor();
  const Vec3 level = mean3(run_on_floor(truth, stand(), 2), "imu_acc");
  EXPECT_NEAR(std::hypot(level[0], level[1], level[2]), kG, 0.01);
  EXPECT_GT(level[2], 0.95 * kG) << "specific force at rest points up";
  truth.gyro_bias = {0.05, -0.03, 0.02};
  truth.acc_bias = {0.2, 0.1, -0.3};
  const Recording biased = run_on_floor(truth, stand(), 2);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean3(biased, "imu_gyro")[i], truth.gyro_bias[i], 0.002);
    EXPECT_NEAR(mean3(biased, "imu_acc")[i] - level[i], truth.acc_bias[i], 0.02);
  }
  FloorTruth turned = nominal_floor();
  turned.imu_turn = {0.0, 0.1, 0.0};  // about y: x sees part of what z saw
  const Vec3 seen = mean3(run_on_floor(turned, stand(), 2), "imu_acc");
  EXPECT_NEAR(seen[0], level[0] * std::cos(0.1) - level[2] * std::sin(0.1), 0.02);
  EXPECT_NEAR(seen[2], level[2] * std::cos(0.1) + level[0] * std::sin(0.1), 0.02);
}

/// Mean normal of the right sole in the world, by the kinematics of the model that is handed out.
Vec3 sole_normal(const Recording& r) {
  const diagnose::WholeBody body = diagnose::parse_whole_body(
      "format = 1\n[robot]\nbase = \"floating\"\n", floor_urdf(nominal_floor()), "model.toml");
  const auto data = diagnose::judge_whole({r}, body, diagnose::Settings{});
  const diagnose::WholeRecording& made = data.recordings.at(0);
  diagnose::BodyKinematics kinematics(body);
  diagnose::V3 sum = diagnose::V3::Zero();
  for (std::size_t k = 0; k < made.rows(); ++k) {
    kinematics.set(made.R[k], made.p[k], made.q.col(static_cast<Eigen::Index>(k)));
    sum += kinematics.rotation(body.model.tree.index_of("r_ank_roll")).col(2);
  }
  sum.normalize();
  return {sum[0], sum[1], sum[2]};
}

// not the trunk's: drives that hold a position give way, and it leans further than the floor
TEST(FloorWorld, SolesLieOnTheSlopeWhateverTheHeading) {
  for (const double heading : {0.0, 1.5}) {
    FloorTruth truth = nominal_floor();
    const Vec3 level = sole_normal(run_on_floor(truth, stand(heading), 3));
    truth.slope = {0.0, 0.05, 0.0};
    const Vec3 leaning = sole_normal(run_on_floor(truth, stand(heading), 3));
    EXPECT_NEAR(level[2], 1.0, 1e-4) << heading;
    EXPECT_NEAR(leaning[0] - level[0], std::sin(0.05), 0.004) << heading;
    EXPECT_NEAR(leaning[1] - level[1], 0.0, 0.004) << heading;
  }
}

TEST(FloorWorld, SeedsDrawNoiseAndNothingElse) {
  const FloorTruth truth = nominal_floor();
  const Recording a = run_on_floor(truth, stand(), 4), again = run_on_floor(truth, stand(), 4),
                  b = run_on_floor(truth, stand(), 5);
  bool differs = false;
  ASSERT_EQ(a.channels.size(), b.channels.size());
  for (std::size_t c = 0; c < a.channels.size(); ++c) {
    EXPECT_EQ(a.channels[c].values, again.channels[c].values) << a.channels[c].name;
    const bool same = a.channels[c].values == b.channels[c].values;
    const bool of_motion =
        a.channels[c].name.starts_with("u:") || a.channels[c].name.starts_with("q:");
    if (of_motion) {
      EXPECT_TRUE(same) << a.channels[c].name;
    }
    differs = differs || !same;
  }
  EXPECT_TRUE(differs);
}

diagnose::WholeBody handed_out() {
  const FloorTruth nominal = nominal_floor();
  return diagnose::parse_whole_body(floor_toml(nominal), floor_urdf(nominal), "model.toml");
}

ConcealOptions options_of(std::uint64_t seed, Family family, const std::string& effect = "") {
  ConcealOptions o;
  o.seed = seed, o.robot = kFloorRobot, o.family = family, o.ratio = 10;
  if (!effect.empty()) o.effect = effect;
  return o;
}

FloorPlan planned(std::uint64_t seed, Family family, const std::string& effect = "") {
  return plan_floor_case(options_of(seed, family, effect));
}

/// The first of a case's recordings: it stands.
Recording standing(const FloorPlan& plan) {
  EXPECT_EQ(plan.motions.front().condition, "stand");
  return run_on_floor(plan.truth, plan.motions.front(), plan.noise.front());
}

TEST(FloorCase, ModelIsTheNominalRobot) {
  const diagnose::WholeBody body = handed_out();
  const FloorTruth nominal = nominal_floor();
  EXPECT_NEAR(body.mass(), mass_of(nominal), 1e-6);
  EXPECT_NEAR(body.base.mass, nominal.trunk.mass, 1e-6);
  EXPECT_EQ(body.shapes.size(), 2u);
}

TEST(FloorCase, CleanIsOffByTolerancesAlone) {
  std::vector<double> forces;
  for (const std::uint64_t seed : {31u, 32u}) {
    const FloorPlan made = planned(seed, Family::clean);
    EXPECT_TRUE(made.answer.at("effects").empty());
    const double weight = mass_of(nominal_floor()) * kG;
    const Recording stands = standing(made);
    forces.push_back(carried(stands));
    // 3 % of every mass, 0.5 % of the sensors; and what the physics rounds
    EXPECT_LE(std::abs(forces.back() / weight - 1), 0.036) << seed;
    const Vec3 gyro = mean3(stands, "imu_gyro");
    EXPECT_LE(std::hypot(gyro[0], gyro[1], gyro[2]), 0.004) << seed;
  }
  EXPECT_NE(forces[0], forces[1]);
}

TEST(FloorCase, TheAnswerIsWhatTheWorldHolds) {
  const double weight = mass_of(nominal_floor()) * kG, tolerance = 0.036 * weight;
  const auto told = [](const FloorPlan& made) {
    const json effects = made.answer.at("effects");
    EXPECT_EQ(effects.size(), 1u);
    return effects.at(0).at("parameters");
  };
  const FloorPlan payload = planned(41, Family::single, "payload");
  EXPECT_NEAR(carried(standing(payload)) - weight, told(payload).at("mass").get<double>() * kG,
              tolerance);
  const FloorPlan scale = planned(42, Family::single, "foot_force_scale");
  EXPECT_NEAR(carried(standing(scale)), told(scale).at("scale").get<double>() * weight,
              1.4 * tolerance);
  const FloorPlan bias = planned(43, Family::single, "imu_bias");
  const Vec3 gyro = mean3(standing(bias), "imu_gyro");
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(gyro[i], told(bias).at(std::string("gyro_") + "xyz"[i]).get<double>(), 0.004);
}

TEST(FloorCase, ADecoyIsRefusedByTheNameOfItsDefect) {
  for (const std::uint64_t seed : {51u, 52u}) {
    const FloorCase made = make_floor_case(options_of(seed, Family::decoy));
    const json decoy = json::parse(made.answer).at("decoy");
    const auto data = diagnose::judge_whole(made.recordings, handed_out(), diagnose::Settings{});
    EXPECT_TRUE(std::any_of(data.defects.begin(), data.defects.end(),
                            [&](const diagnose::Defect& d) {
                              return d.defect == decoy.at("defect").get<std::string>() &&
                                     d.file == decoy.at("file").get<std::string>();
                            }))
        << decoy.dump();
  }
}

TEST(FloorCase, WhatNoLibraryHasIsOfAnotherFamily) {
  for (const FloorEffect& e : floor_effects()) {
    const json answer = planned(7, Family::outside, e.id).answer;
    EXPECT_EQ(answer.at("effects").at(0).at("id"), e.id);
    EXPECT_EQ(diagnose::find_effect(e.id) != nullptr, e.in_library) << e.id;
    if (e.in_library) continue;
    EXPECT_EQ(answer.at("family"), "outside");
    EXPECT_EQ(answer.at("effects").at(0).at("where").size(), 1u);
  }
}

/// Mean of what a joint's goal and reading are apart.
double error_of(const FloorTruth& truth, const FloorMotion& motion, const std::string& joint) {
  const Recording r = run_on_floor(truth, motion, 6);
  return mean(r, "u:" + joint) - mean(r, "q:" + joint);
}

TEST(FloorWorld, DrivesAreAsTheyAreHidden) {
  FloorMotion squat = stand();
  squat.squat = 0.3;
  const FloorTruth nominal = nominal_floor();
  const double as_stated = error_of(nominal, squat, "l_knee");
  FloorTruth stiffer = nominal;
  for (FloorDrive& d : stiffer.drives) d.gain = 1.5;
  EXPECT_NEAR(error_of(stiffer, squat, "l_knee"), as_stated / 1.5, 0.05 * std::abs(as_stated));
  // a wrong zero is read, and held: the leg bends, the reading hardly changes
  FloorTruth off = nominal;
  for (std::size_t j = 0; j < off.drives.size(); ++j)
    if (off.legs.links[j].joint == "l_knee") off.drives[j].zero = 0.05;
  EXPECT_NEAR(error_of(off, squat, "l_knee"), as_stated, 0.02);
}

TEST(FloorCase, FilesAreWhatWasPlanned) {
  const test::TempFolder folder;
  ConcealOptions o = options_of(61, Family::single);
  o.out = (folder.path() / "case").string();
  const Concealed written = conceal(o);
  const FloorPlan plan = plan_floor_case(o);
  ASSERT_EQ(written.recordings.size(), plan.motions.size()) << "it fell";
  for (const std::size_t i : {0u, 4u}) {
    const Recording made = run_on_floor(plan.truth, plan.motions[i], plan.noise[i]);
    const Recording read = recording::read_csv(written.recordings[i]);
    EXPECT_EQ(read.t, made.t);
    EXPECT_EQ(read.condition, made.condition);
    for (const recording::Channel& c : made.channels) {
      const auto column = read.find(c.name);
      EXPECT_EQ(std::vector<double>(column.begin(), column.end()), c.values) << c.name;
    }
  }
  std::ifstream in(folder.path() / "case" / "answer.sealed", std::ios::binary);
  const std::vector<std::uint8_t> sealed((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(json::parse(open_seal(sealed)), plan.answer);
  EXPECT_EQ(diagnose::read_whole_body(written.model).mass(), handed_out().mass());
}

TEST(FloorCase, AGoalLeaksFromOneThatMoves) {
  FloorMotion sway = stand();
  sway.condition = "sway", sway.sway = 0.08, sway.squat = 0.3, sway.rate_hz = 0.5;
  const FloorTruth nominal = nominal_floor();
  const Recording tight = run_on_floor(nominal, sway, 3);
  for (std::size_t j = 0; j < nominal.drives.size(); ++j) {
    const std::string& joint = nominal.legs.links[j].joint;
    if (!joint.ends_with("ank_roll") && !joint.ends_with("hip_yaw")) continue;
    FloorTruth leaks = nominal;
    leaks.drives[j].leak = 0.5;
    const Recording leaking = run_on_floor(leaks, sway, 3);
    const auto a = tight.find("q:" + joint), b = leaking.find("q:" + joint);
    double most = 0.0;
    for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k)
      most = std::max(most, std::abs(a[k] - b[k]));
    EXPECT_GT(most, 0.01) << joint;
  }
}

/// Half as much again, 40 mm behind: this robot falls at once, and another one is drawn.
TEST(FloorCase, ARobotThatFallsIsDrawnAnew) {
  const ConcealOptions o = options_of(511430, Family::pair);
  const FloorPlan falls = plan_floor_case(o);
  EXPECT_LT(run_on_floor(falls.truth, falls.motions.front(), falls.noise.front()).rows(), 200u);
  EXPECT_GE(2 * make_floor_case(o).recordings.size(), falls.motions.size());
}

TEST(FloorCase, WhatItCannotHideIsRefusedByName) {
  const auto message = [](Family family, const std::string& effect) {
    try {
      planned(1, family, effect);
    } catch (const plant::WorldError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message(Family::ambiguous, "").find("expected clean"), std::string::npos);
  EXPECT_NE(message(Family::single, "backlash").find("backlash"), std::string::npos);
}

}  // namespace
}  // namespace sanso::conceal
