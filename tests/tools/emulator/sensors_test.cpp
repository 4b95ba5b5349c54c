// IMU and tracking camera: bytes as published, rates, faults.
#include <gtest/gtest.h>

#include <cmath>

#include "shared/base/pose_report.h"
#include "shared/servo_bus/packet.h"
#include "tests/shared/servo_bus/hex.h"
#include "tools/emulator/emulated_robot.h"
#include "tools/emulator/hid_imu.h"

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
