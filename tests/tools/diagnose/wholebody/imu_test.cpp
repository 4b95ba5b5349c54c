// A turned or biased IMU is recovered from the base's motion, and the patched model has it.
#include <gtest/gtest.h>

#include "tests/tools/diagnose/wholebody/made_body.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kG = 9.81;

/// A trunk that sways about all axes and moves, with an IMU at `at` of it.
recording::Recording swaying(const Eigen::Matrix3d& R_base_imu, const V3& at, const V3& gyro_bias,
                             double swing) {
  recording::Recording r;
  r.file = "sway.csv";
  Random random(5);
  std::vector<V3> p, acc, gyro;
  std::vector<Eigen::Quaterniond> q;
  // attitude about fixed axes, one after the other; rates and accelerations by differences
  const auto attitude = [&](double t) {
    return Eigen::AngleAxisd(0.5 * swing * std::sin(0.7 * t), V3::UnitZ()) *
           Eigen::AngleAxisd(swing * std::sin(2.1 * t), V3::UnitY()) *
           Eigen::AngleAxisd(swing * std::sin(1.3 * t + 1.0), V3::UnitX());
  };
  const auto place = [&](double t) {
    return V3(0.1 * std::sin(1.1 * t), 0.05 * std::cos(1.7 * t), 0.3 + 0.02 * std::sin(2.9 * t));
  };
  const auto imu = [&](double t) { return V3(place(t) + attitude(t) * at); };
  constexpr double h = 1e-4;
  for (double t = 0.0; t < 20.0; t += 0.01) {
    const Eigen::Quaterniond now(attitude(t)), before(attitude(t - h)), after(attitude(t + h));
    const V3 a = (imu(t + h) - 2.0 * imu(t) + imu(t - h)) / (h * h);
    const Eigen::AngleAxisd turn(before.conjugate() * after);
    const auto noise = [&](double s) {
      return V3(s * random.normal(), s * random.normal(), s * random.normal());
    };
    r.t.push_back(t), p.push_back(place(t) + noise(1e-4)), q.push_back(now);
    acc.push_back(R_base_imu.transpose() * (now.conjugate() * (a + V3(0, 0, kG))) + noise(0.05));
    gyro.push_back(R_base_imu.transpose() * (turn.axis() * turn.angle() / (2 * h)) + gyro_bias +
                   noise(0.005));
  }
  put(r, "base_p", "xyz", [&](auto k, auto i) { return p[k][static_cast<long>(i)]; });
  put(r, "base_q", "wxyz", [&](auto k, auto i) { return part_of(q[k], i); });
  put(r, "imu_acc", "xyz", [&](auto k, auto i) { return acc[k][static_cast<long>(i)]; });
  put(r, "imu_gyro", "xyz", [&](auto k, auto i) { return gyro[k][static_cast<long>(i)]; });
  return r;
}

const Eigen::Matrix3d kStraight = Eigen::Matrix3d::Identity();
constexpr const char* kAt = "[imu]\nlink = \"ball\"\nxyz = [0.05, -0.02, 0.1]\n";
const V3 kPlace(0.05, -0.02, 0.1);

TEST(Imu, NothingIsFoundWhereItSitsAsStated) {
  const Verdict v =
      diagnosed(body_of(kAt, kBall), {swaying(kStraight, kPlace, V3::Zero(), 0.3)}).verdict;
  EXPECT_EQ(v.status, VerdictStatus::absent) << told(v);
}

TEST(Imu, AnyTurnIsRecoveredAndThePatchHasIt) {
  const Eigen::AngleAxisd small(0.06, V3(1, 2, -1).normalized());
  const Eigen::AngleAxisd gross(2.1, V3(0.3, -1, 0.5).normalized());
  for (const Eigen::AngleAxisd& turn : {small, gross}) {
    const auto recording = swaying(turn.toRotationMatrix(), kPlace, V3::Zero(), 0.3);
    const WholeDiagnosis d = diagnosed(body_of(kAt, kBall), {recording});
    const Finding* f = find(d.verdict, "imu_misalignment");
    ASSERT_NE(f, nullptr) << turn.angle() << ": " << told(d.verdict);
    EXPECT_EQ(f->status, VerdictStatus::confirmed);
    // reading = turned back from base axes into the sensor's
    const V3 expected = -turn.angle() * turn.axis();
    const char* names[] = {"x", "y", "z"};
    for (long i = 0; i < 3; ++i)
      EXPECT_NEAR(f->parameters.at(names[i]).value, expected[i], 0.01) << turn.angle();
    const WholeBody again = parse_whole_body(whole_body_toml(*d.patched), kBall, "again");
    EXPECT_LT((eigen(again.imu.R_joint_imu) - turn.toRotationMatrix()).norm(), 0.02);
    EXPECT_EQ(find(diagnosed(again, {recording}).verdict, "imu_misalignment"), nullptr);
  }
}

TEST(Imu, ASmallTurnOfAnImuThatHardlyMovesMayBeTheVerticalInstead) {
  const Eigen::AngleAxisd turn(0.08, V3::UnitY());
  const Verdict v =
      diagnosed(body_of(kAt, kBall), {swaying(turn.toRotationMatrix(), kPlace, V3::Zero(), 0.01)})
          .verdict;
  const Finding* f = find(v, "imu_misalignment");
  ASSERT_NE(f, nullptr) << told(v);
  EXPECT_EQ(f->status, VerdictStatus::one_of);
}

TEST(Imu, ATurnAndABiasThatCancelAreNotNamed) {
  // a gyroscope whose axes alone are a little off: with an accelerometer that reads as it should,
  // a turned IMU needs a bias that hides it
  recording::Recording r = swaying(kStraight, kPlace, V3::Zero(), 0.04);
  const Eigen::Matrix3d off = Eigen::AngleAxisd(0.1, V3::UnitY()).toRotationMatrix();
  const auto column = [&](const char* name) {
    const auto x = r.find(name);
    return std::vector<double>(x.begin(), x.end());
  };
  const auto x = column("imu_gyro:x"), y = column("imu_gyro:y"), z = column("imu_gyro:z");
  put(r, "imu_gyro", "xyz",
      [&](auto k, auto i) { return (off * V3(x[k], y[k], z[k]))[static_cast<long>(i)]; });
  const Verdict v = diagnosed(body_of(kAt, kBall), {r}).verdict;
  EXPECT_EQ(find(v, "imu_misalignment"), nullptr) << told(v);
  EXPECT_EQ(find(v, "imu_bias"), nullptr) << told(v);
}

TEST(Imu, WhatIsKnownOfATurnIsSaidByAxis) {
  const Eigen::AngleAxisd turn(0.06, V3(1, 2, -1).normalized());
  const WholeDiagnosis d =
      diagnosed(body_of(kAt, kBall), {swaying(turn.toRotationMatrix(), kPlace, V3::Zero(), 0.3)});
  const Finding* f = find(d.verdict, "imu_misalignment");
  ASSERT_NE(f, nullptr) << told(d.verdict);
  const V3 expected = -turn.angle() * turn.axis();
  const char* names[] = {"x", "y", "z"};
  for (long i = 0; i < 3; ++i) EXPECT_TRUE(holds(f->parameters.at(names[i]), expected[i])) << i;
}

TEST(Imu, ABiasOfTheGyroscopeIsNoTurn) {
  const V3 bias(0.0, 0.08, -0.03);
  const WholeDiagnosis d = diagnosed(body_of(kAt, kBall), {swaying(kStraight, kPlace, bias, 0.3)});
  const Finding* f = find(d.verdict, "imu_bias");
  ASSERT_NE(f, nullptr) << told(d.verdict);
  EXPECT_NEAR(f->parameters.at("gyro_y").value, 0.08, 0.003);
  EXPECT_NEAR(f->parameters.at("gyro_z").value, -0.03, 0.003);
  EXPECT_EQ(find(d.verdict, "imu_misalignment"), nullptr) << told(d.verdict);
}

}  // namespace
}  // namespace sanso::diagnose
