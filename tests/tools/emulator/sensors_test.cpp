// IMU and tracking camera: bytes as published, rates, faults.
#include <gtest/gtest.h>

#include <cmath>

#include "shared/base/pose_report.h"
#include "shared/servo_bus/packet.h"
#include "tests/shared/servo_bus/hex.h"
#include "tools/emulator/emulated_robot.h"
#include "tools/emulator/hid_imu.h"
#include "tools/emulator/pose_source.h"

namespace sanso::emulator {
namespace {

using servo_bus::bytes;
using servo_bus::hex;

plant::ImuParameters exact() {
  plant::ImuParameters p;
  p.accel_noise_m_s2 = p.gyro_noise_rad_s = p.orientation_noise_rad = 0;
  return p;
}

TEST(HidImu, DescriptorIsTheExampleDevices) {
  const auto d = HidImu::descriptor();
  EXPECT_EQ(d.size(), 576u);
  EXPECT_EQ(hex(d.first(16)), "05 20 09 01 A1 01 09 73 A1 00 85 01 55 00 0A 16");
  EXPECT_EQ(hex(d.subspan(553)),
            "0A 83 04 17 01 00 00 80 27 FF FF FF 7F 75 20 95 04 55 09 81 02 C0 C0");
}

TEST(HidImu, ReportsAreTheExampleBytes) {
  HidImu imu(exact(), 1);
  std::uint8_t buffer[64];
  for (int id = 1; id <= 3; ++id) {
    auto feature = bytes("00 01 01 05 00 00 00");
    feature[0] = static_cast<std::uint8_t>(id);
    ASSERT_TRUE(imu.set_feature(feature));
  }
  constexpr double g = 9.80665, deg = plant::kPi / 180;
  const ImuTruth truth{{0.012 * g, -0.035 * g, 0.998 * g},
                       {1.5 * deg, -0.25 * deg, 30.125 * deg},
                       {std::cos(5 * deg), 0, std::sin(5 * deg), 0}};
  for (int ms = 0; ms < 3; ++ms) imu.update(ms * kMillisecond, truth, false, false);
  ASSERT_EQ(imu.read(buffer), 9u);
  EXPECT_EQ(hex({buffer, 9}), "01 01 03 0C 00 DD FF E6 03");
  ASSERT_EQ(imu.read(buffer), 15u);
  EXPECT_EQ(hex({buffer, 15}), "02 01 03 98 3A 00 00 3C F6 FF FF C2 98 04 00");
  ASSERT_EQ(imu.read(buffer), 19u);
  EXPECT_EQ(hex({buffer, 19}), "03 01 03 00 00 00 00 85 4C 0D 00 00 00 00 00 DB 01 98 00");
  EXPECT_EQ(imu.read(buffer), 0u);
}

/// Orientation after `seconds` in which the sensor feels `force`, base axes, and does not turn.
plant::Quat felt_orientation(const plant::ImuParameters& p, const plant::Vec3& force,
                             double seconds) {
  HidImu imu(p, 1);
  EXPECT_TRUE(imu.set_feature(bytes("03 01 01 05 00 00 00")));
  std::uint8_t buffer[64];
  plant::Quat q{};
  for (int ms = 0; ms < 1000 * seconds; ++ms) {
    imu.update(ms * kMillisecond, {force, {0, 0, 0}, {1, 0, 0, 0}}, false, false);
    if (imu.read(buffer) == 0) continue;
    for (std::size_t i = 0; i < 4; ++i)  // x y z w
      q[(i + 1) % 4] =
          1e-7 * static_cast<std::int32_t>(servo_bus::get_u32({buffer + 3 + 4 * i, 4}));
  }
  return q;
}

TEST(HidImu, TakesAnAccelerationForATiltWithItsTimeConstant) {
  plant::ImuParameters p = exact();
  p.gravity_filter_s = 2.0;
  constexpr double kG = 9.81;
  EXPECT_NEAR(felt_orientation(p, {0, 0, kG}, 5.0)[2], 0.0, 1e-6) << "nothing to mistake at rest";
  // accelerating forward looks like a nose that rises: the felt up leans forward
  const double slope = std::sin(std::atan2(1.0, kG));
  const plant::Quat q = felt_orientation(p, {1.0, 0, kG}, 2.0);
  EXPECT_NEAR(2.0 * std::asin(q[2]), -slope * (1.0 - std::exp(-1.0)), 0.003);
  EXPECT_NEAR(q[1], 0.0, 1e-6);
  EXPECT_NEAR(felt_orientation(exact(), {1.0, 0, kG}, 2.0)[2], 0.0, 1e-6) << "no filter, no error";
}

TEST(HidImu, HeadingRunsAwayAtItsRate) {
  plant::ImuParameters p = exact();
  p.yaw_drift_rad_s = 0.01;
  const plant::Quat q = felt_orientation(p, {0, 0, 9.81}, 10.0);
  EXPECT_NEAR(2.0 * std::asin(q[3]), 0.1, 0.001);
}

TEST(PoseSource, DropsOutAsOftenAsItsWorldSays) {
  plant::PoseParameters p;
  p.delay_s = 0.0;
  p.dropouts_per_s = 0.5;
  p.dropout_s = 0.2;
  PoseSource source(p, 1);
  std::vector<std::uint8_t> buffer(kPoseReportBytes);
  int lost = 0, all = 0;
  for (std::int64_t ms = 0; ms < 400'000; ++ms) {
    source.update(ms * kMillisecond, {}, false);
    if (source.read(buffer, ms * kMillisecond) == 0) continue;
    ++all;
    lost += decode_pose_report(buffer)->confidence == 0;
  }
  // begun at 0.5 a second, 0.2 s each, those that begin within another not counted twice
  EXPECT_NEAR(static_cast<double>(lost) / all, 1.0 - std::exp(-0.5 * 0.2), 0.02);
}

TEST(PoseSource, DriftsAsTheRootOfTime) {
  plant::PoseParameters p;
  p.delay_s = p.position_noise_m = 0.0;
  p.drift_m = 0.01;
  std::vector<std::uint8_t> buffer(kPoseReportBytes);
  double at_one = 0.0, at_four = 0.0;
  constexpr int kSources = 300;
  for (std::uint64_t seed = 0; seed < kSources; ++seed) {
    PoseSource source(p, seed);
    for (std::int64_t ms = 0; ms <= 4000; ++ms) {
      source.update(ms * kMillisecond, {}, false);
      if (source.read(buffer, ms * kMillisecond) == 0 || (ms != 1000 && ms != 4000)) continue;
      const double x = decode_pose_report(buffer)->p_world_base[0];
      (ms == 1000 ? at_one : at_four) += x * x;
    }
  }
  // the deviation of 300 draws is known to 4 %
  EXPECT_NEAR(std::sqrt(at_one / kSources), p.drift_m, 0.16 * p.drift_m);
  EXPECT_NEAR(std::sqrt(at_four / kSources), 2.0 * p.drift_m, 0.32 * p.drift_m);
}

TEST(HidImu, SilentUntilAskedAndFeaturesReadBack) {
  EmulatedRobot robot(plant::load_world("nominal"), 1);
  std::uint8_t buffer[64];
  robot.advance(100 * kMillisecond);
  EXPECT_EQ(robot.imu_read(buffer), 0u);
  EXPECT_FALSE(robot.imu_set_feature(bytes("04 01 01 05 00 00 00")));
  EXPECT_FALSE(robot.imu_set_feature(bytes("02 01 01 05 00")));
  ASSERT_TRUE(robot.imu_set_feature(bytes("02 01 01 05 00 00 00")));
  ASSERT_EQ(robot.imu_get_feature(2, buffer), 7u);
  EXPECT_EQ(hex({buffer, 7}), "02 01 01 05 00 00 00");
  robot.advance(200 * kMillisecond);
  int reports = 0;
  while (robot.imu_read(buffer)) ++reports;
  EXPECT_NEAR(reports, 20, 1);
}

TEST(HidImu, FeelsGravityAtRestAndFaultsSilenceOrFreezeIt) {
  EmulatedRobot robot(plant::load_world("nominal"), 1);
  std::uint8_t buffer[64];
  ASSERT_TRUE(robot.imu_set_feature(bytes("01 01 01 0A 00 00 00")));
  robot.advance(kSecond);
  while (robot.imu_read(buffer)) {
  }
  robot.advance(1100 * kMillisecond);
  ASSERT_EQ(robot.imu_read(buffer), 9u);
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = servo_bus::get_i16({buffer + 3 + 2 * axis, 2}) * 1e-3;
    square += a * a;
  }
  EXPECT_NEAR(std::sqrt(square), 1.0, 0.03);

  robot.faults().add({FaultKind::imu_frozen, 0, 0, 2 * kSecond});
  robot.faults().add({FaultKind::imu_silent, 0, 2 * kSecond, 3 * kSecond});
  while (robot.imu_read(buffer)) {
  }
  robot.advance(1300 * kMillisecond);
  std::string first;
  for (std::size_t size; (size = robot.imu_read(buffer));) {
    if (first.empty()) first = hex({buffer, size});
    EXPECT_EQ(hex({buffer, size}), first);
  }
  EXPECT_FALSE(first.empty());
  robot.advance(2100 * kMillisecond);
  while (robot.imu_read(buffer)) {
  }
  robot.advance(2900 * kMillisecond);
  EXPECT_EQ(robot.imu_read(buffer), 0u);
}

TEST(PoseSource, TwoHundredTimesASecondWithDelayAndNoise) {
  EmulatedRobot robot(plant::load_world("lab"), 1);
  std::uint8_t buffer[64];
  robot.advance(kSecond);
  int count = 0;
  std::uint32_t sequence = 0;
  const Truth truth = robot.truth();
  while (const std::size_t size = robot.pose_read(buffer)) {
    const auto report = decode_pose_report({buffer, size});
    ASSERT_TRUE(report.ok());
    if (count > 0) {
      EXPECT_EQ(report->sequence, sequence + 1);
    }
    sequence = report->sequence;
    EXPECT_NEAR(report->p_world_base[2], truth.p_world_base[2], 0.006);
    EXPECT_EQ(report->age_us, 8000u);
    EXPECT_EQ(report->confidence, 3);
    ++count;
  }
  EXPECT_GE(count, 60);  // the queue keeps the newest 64
}

TEST(PoseReport, RefusesWhatIsNoPose) {
  const auto good = encode_pose_report({});
  EXPECT_TRUE(decode_pose_report(good).ok());
  auto bad = good;
  bad[0] = 1;
  EXPECT_EQ(decode_pose_report(bad).status(), Status::malformed);
  EXPECT_EQ(decode_pose_report(std::span(good).first(51)).status(), Status::malformed);
  PoseReport report;
  report.p_world_base[1] = NAN;
  EXPECT_EQ(decode_pose_report(encode_pose_report(report)).status(), Status::out_of_range);
  report = {};
  report.quat_world_base = {0.5f, 0, 0, 0};
  EXPECT_EQ(decode_pose_report(encode_pose_report(report)).status(), Status::out_of_range);
}

}  // namespace
}  // namespace sanso::emulator
