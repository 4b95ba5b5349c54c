// Laws of what leans: the world's part and the robot's are told apart by headings alone, against
// leans made by rotations; where headings are alike neither is believed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/tools/diagnose/wholebody/made_body.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kZero = 0.0015;  // rad

/// Readings of `recordings` stances with these headings, both feet, each foot bent a little.
Leans standing(const V2& world, const V2& body, const std::vector<double>& headings,
               double own = 0.0) {
  Leans leans;
  Random random(11);
  for (std::size_t r = 0; r < headings.size(); ++r) {
    const Eigen::Rotation2Dd turn(headings[r]);
    const V2 its = own * V2(std::cos(2.0 * static_cast<double>(r)), std::sin(2.0 * double(r)));
    for (int piece = 0; piece < 6; ++piece) {
      for (int k = 0; k < 50; ++k) {
        const V2 noise(1e-3 * random.normal(), 1e-3 * random.normal());
        for (const double bent : {0.002, -0.002})
          leans.add(world + its + turn * (body + V2(bent, 0.0)) + noise, headings[r],
                    bent > 0 ? "l" : "r", static_cast<int>(r), piece,
                    static_cast<int>(6 * r) + piece);
      }
    }
  }
  return leans;
}

LeanFit fitted(const Leans& leans) { return *LeanFit::of(leans, kZero, {}); }

TEST(Lean, WorldAndRobotAreToldApartByHeadings) {
  const V2 world(0.02, -0.01), body(-0.015, 0.03);
  const LeanFit fit = fitted(standing(world, body, {0.3, 2.5, -1.4, -2.8, 1.2}));
  EXPECT_LT((fit.in_world - world).norm(), 3.0 * fit.world.sigma + 1e-4);
  EXPECT_LT((fit.in_body - body).norm(), 3.0 * fit.body.sigma + 1e-4);
  EXPECT_LT(fit.world.sigma, 0.002);
  EXPECT_GT(fit.world.gain_low, 0.0);
  EXPECT_GT(fit.body.gain_low, 0.0);
  EXPECT_LT(fit.apart.value, 0.001);
}

TEST(Lean, WithOneHeadingNeitherIsKnownAndTheirSumIs) {
  const V2 world(0.02, -0.01);
  for (const double heading : {0.0, 1.1}) {
    const LeanFit fit = fitted(standing(world, V2::Zero(), {heading, heading, heading, heading}));
    EXPECT_GT(fit.world.sigma, 0.05);
    EXPECT_GT(fit.body.sigma, 0.05);
    EXPECT_LT((fit.alike - world).norm(), 3.0 * fit.together.sigma);
    EXPECT_LT(fit.together.sigma, 0.003);
  }
}

TEST(Lean, TheNearerTheHeadingsTheLessIsKnown) {
  double before = 0.0;
  for (const double spread : {3.0, 1.0, 0.3, 0.1, 0.03}) {
    const LeanFit fit = fitted(
        standing({0.01, 0.0}, V2::Zero(), {-spread / 2, spread / 2, -spread / 2, spread / 2}));
    EXPECT_GT(fit.world.sigma, before) << spread;
    EXPECT_LT((fit.in_world - V2(0.01, 0.0)).norm(), 4.0 * fit.world.sigma) << spread;
    before = fit.world.sigma;
  }
}

TEST(Lean, RecordingsWithWorldsOfTheirOwnAreSeen) {
  const LeanFit fit = fitted(standing(V2::Zero(), V2::Zero(), {0, 0, 0, 0, 0, 0}, 0.03));
  EXPECT_NEAR(fit.apart.value, 0.03, 0.005);
  EXPECT_GT(fit.apart.gain_low, 0.0);
}

TEST(Lean, OneRecordingThatTipsIsNoFloorOfItsOwn) {
  Leans leans;
  Random random(12);
  for (std::size_t r = 0; r < 7; ++r) {
    for (int piece = 0; piece < 6; ++piece) {
      for (int k = 0; k < 50; ++k) {
        const V2 noise(1e-3 * random.normal(), 1e-3 * random.normal());
        leans.add(noise + V2(r == 3 ? 0.06 : 0.0, 0.0), 0.4 * double(r), "l", static_cast<int>(r),
                  piece, static_cast<int>(6 * r) + piece);
      }
    }
  }
  EXPECT_LT(fitted(leans).apart.value, 0.01);
}

TEST(Lean, FewGroupsSayNothing) {
  Leans leans;
  for (int k = 0; k < 100; ++k) leans.add({0.1, 0.0}, 0.0, "l", 0, 0, k % 3);
  EXPECT_FALSE(LeanFit::of(leans, kZero, {}));
}

// ---- the same through recordings: a robot on two legs that stands in several headings

struct Floor {
  V2 slope = V2::Zero();  // of the floor about world x and y, rad
  V2 frame = V2::Zero();  // of the poses' axes: they lean so, and gravity does not
  double attitude = 0.0;  // recorded too far about the base's y, rad
  bool imu = true;
};

/// Stands flat on the floor in one heading; soles under straight legs are square to the trunk.
recording::Recording stands(const Floor& floor, double heading, int number) {
  recording::Recording r;
  r.file = "stand_" + std::to_string(number) + ".csv";
  Random random(static_cast<unsigned long>(number));
  const auto turned_by = [](const V2& v) {
    const V3 rotation(v[0], v[1], 0.0);
    return Eigen::Quaterniond(rotation.norm() > 0.0
                                  ? Eigen::AngleAxisd(rotation.norm(), rotation.normalized())
                                  : Eigen::AngleAxisd(0.0, V3::UnitX()));
  };
  const Eigen::Quaterniond stood = turned_by(floor.slope) * Eigen::AngleAxisd(heading, V3::UnitZ());
  const Eigen::Quaterniond told =
      turned_by(floor.frame) * stood * Eigen::AngleAxisd(floor.attitude, V3::UnitY());
  for (double t = 0.0; t < 6.0; t += 0.01) r.t.push_back(t);
  std::vector<V3> shake;
  for (std::size_t k = 0; k < r.rows(); ++k)
    shake.emplace_back(random.normal(), random.normal(), random.normal());
  put(r, "q", "lr", [](auto, auto) { return 0.0; });
  put(r, "base_p", "xyz", [&](auto k, auto i) { return 1e-4 * shake[k][static_cast<long>(i)]; });
  put(r, "base_q", "wxyz", [&](auto k, auto i) {
    const Eigen::Quaterniond jitter(1.0, 3e-4 * shake[k][1], 3e-4 * shake[k][2], 0.0);
    return part_of((told * jitter).normalized(), i);
  });
  if (floor.imu)
    put(r, "imu_acc", "xyz", [&](auto k, auto i) {
      const V3 felt = stood.conjugate() * V3(0, 0, 9.81);
      return felt[static_cast<long>(i)] + 0.05 * shake[k][static_cast<long>(i)];
    });
  for (const char* foot : {"fz:l_foot", "fz:r_foot"})
    r.set(foot, std::vector<double>(r.rows(), 0.5 * 5.0 * 9.81));
  return r;
}

WholeDiagnosis on(const Floor& floor, const std::vector<double>& headings,
                  const std::string& toml = "") {
  std::vector<recording::Recording> all;
  for (std::size_t i = 0; i < headings.size(); ++i)
    all.push_back(stands(floor, headings[i], static_cast<int>(i) + 1));
  return diagnosed(body_of(toml, kTwoLegs), all);
}

const std::vector<double> kAround = {0.2, 1.9, -2.4, -0.9};

bool may_be(const Finding& f, const std::string& name) {
  return std::find(f.one_of.begin(), f.one_of.end(), name) != f.one_of.end();
}

TEST(Soles, ALevelFloorIsNotAccused) {
  const Verdict v = on({}, kAround).verdict;
  EXPECT_EQ(v.status, VerdictStatus::absent) << told(v);
}

TEST(Soles, ASlopeIsConfirmedWhereTheRobotTurnsAndAnAccelerometerVouches) {
  const WholeDiagnosis d = on({.slope = {0.02, -0.03}}, kAround);
  const Finding* f = find(d.verdict, "ground_slope");
  ASSERT_NE(f, nullptr) << told(d.verdict);
  EXPECT_EQ(f->status, VerdictStatus::confirmed);
  EXPECT_NEAR(f->parameters.at("x").value, 0.02, 0.002);
  EXPECT_NEAR(f->parameters.at("y").value, -0.03, 0.002);
  EXPECT_EQ(d.verdict.findings.size(), 1U) << told(d.verdict);
  // what was found is known the next time
  ASSERT_TRUE(d.patched);
  const std::string toml = whole_body_toml(*d.patched);
  EXPECT_NE(toml.find("ground_slope"), std::string::npos);
  EXPECT_EQ(
      on({.slope = {0.02, -0.03}}, kAround, toml.substr(toml.find("[[effect]]"))).verdict.status,
      VerdictStatus::absent);
}

TEST(Soles, WithoutAnAccelerometerItMayBeTheVerticalOfThePoses) {
  const Verdict v = on({.slope = {0.02, -0.03}, .imu = false}, kAround).verdict;
  const Finding* f = find(v, "ground_slope");
  ASSERT_NE(f, nullptr) << told(v);
  EXPECT_EQ(f->status, VerdictStatus::one_of);
  EXPECT_TRUE(may_be(*f, "pose_tilt"));
}

TEST(Soles, PosesWhoseAxesLeanAreNoSlope) {
  const Verdict v = on({.frame = {0.025, 0.02}}, kAround).verdict;
  EXPECT_EQ(find(v, "ground_slope"), nullptr) << told(v);
  const Finding* f = find(v, "pose_tilt");
  ASSERT_NE(f, nullptr) << told(v);
  EXPECT_NEAR(f->parameters.at("x").value, 0.025, 0.002);
  EXPECT_NEAR(f->parameters.at("y").value, 0.02, 0.002);
}

TEST(Soles, WhatLeansWithTheRobotIsNoSlope) {
  const Verdict v = on({.attitude = 0.04}, kAround).verdict;
  EXPECT_EQ(find(v, "ground_slope"), nullptr) << told(v);
  const Finding* f = find(v, "imu_misalignment");
  ASSERT_NE(f, nullptr) << told(v);
}

TEST(Soles, InOneHeadingAllNamesStayASet) {
  for (const Floor& floor : {Floor{.slope = {0.0, 0.04}}, Floor{.attitude = 0.04}}) {
    const Verdict v = on(floor, {0.7, 0.7, 0.7}).verdict;
    const Finding* f = find(v, "ground_slope");
    ASSERT_NE(f, nullptr) << told(v);
    EXPECT_EQ(f->status, VerdictStatus::one_of);
    EXPECT_TRUE(may_be(*f, "imu_misalignment"));
    EXPECT_TRUE(may_be(*f, "encoder_offset"));
  }
}

}  // namespace
}  // namespace sanso::diagnose
