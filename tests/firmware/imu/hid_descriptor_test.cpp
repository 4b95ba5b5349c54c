// The HID sensor descriptor: layout found, bytes scaled, nonsense refused.
#include "firmware/imu/hid_descriptor.h"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "tools/emulator/emulated_robot.h"

namespace sanso::firmware {
namespace {

std::vector<std::uint8_t> example() {
  const auto d = emulator::EmulatedRobot::imu_descriptor();
  return {d.begin(), d.end()};
}

const HidField* field_of(const HidLayout& layout, HidQuantity quantity, int component) {
  for (const HidField& f : layout.fields)
    if (f.quantity == quantity && f.component == component) return &f;
  return nullptr;
}

double value_of(const HidLayout& layout, HidQuantity quantity, int component, int index,
                std::span<const std::uint8_t> report) {
  double v = 0;
  const HidField* f = field_of(layout, quantity, component);
  EXPECT_NE(f, nullptr);
  EXPECT_TRUE(read_hid_field(*f, index, report, v));
  return v;
}

TEST(HidDescriptor, FindsThreeSensorsInTheExampleDevice) {
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(example(), layout), Status::ok);
  EXPECT_EQ(layout.fields.size(), 7u);  // 3 accelerations, 3 rates, 1 quaternion of 4
  EXPECT_EQ(layout.features.size(), 3u);
}

TEST(HidDescriptor, ScalesTheExampleReports) {
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(example(), layout), Status::ok);
  // 0.012, -0.035, 0.998 g
  const std::vector<std::uint8_t> accel = {0x01, 0x01, 0x03, 0x0C, 0x00, 0xDD, 0xFF, 0xE6, 0x03};
  EXPECT_NEAR(value_of(layout, HidQuantity::acceleration, 0, 0, accel), 0.012 * 9.80665, 1e-9);
  EXPECT_NEAR(value_of(layout, HidQuantity::acceleration, 1, 0, accel), -0.035 * 9.80665, 1e-9);
  EXPECT_NEAR(value_of(layout, HidQuantity::acceleration, 2, 0, accel), 0.998 * 9.80665, 1e-9);
  // 1.5, -0.25, 30.125 deg/s
  const std::vector<std::uint8_t> gyro = {0x02, 0x01, 0x03, 0x98, 0x3A, 0,    0, 0x3C,
                                          0xF6, 0xFF, 0xFF, 0xC2, 0x98, 0x04, 0};
  EXPECT_NEAR(value_of(layout, HidQuantity::angular_velocity, 1, 0, gyro),
              -0.25 * 0.0174532925199433, 1e-9);
  EXPECT_NEAR(value_of(layout, HidQuantity::angular_velocity, 2, 0, gyro),
              30.125 * 0.0174532925199433, 1e-9);
  // 10 deg about y, order x y z w
  const std::vector<std::uint8_t> quat = {0x03, 0x01, 0x03, 0, 0, 0,    0,    0x85, 0x4C, 0x0D,
                                          0,    0,    0,    0, 0, 0xDB, 0x01, 0x98, 0};
  EXPECT_NEAR(value_of(layout, HidQuantity::quaternion, 0, 1, quat), 0.0871557, 1e-7);
  EXPECT_NEAR(value_of(layout, HidQuantity::quaternion, 0, 3, quat), 0.9961947, 1e-7);
}

TEST(HidDescriptor, MakesTheExampleFeatureReport) {
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(example(), layout), Status::ok);
  std::array<std::uint8_t, 16> out{};
  const std::array<std::uint8_t, 7> expected = {0x02, 0x01, 0x01, 0x05, 0x00, 0x00, 0x00};
  for (const HidFeature& feature : layout.features) {
    if (feature.report_id != 2) continue;
    ASSERT_EQ(make_feature_report(feature, 5, out), expected.size());
    EXPECT_TRUE(std::equal(expected.begin(), expected.end(), out.begin()));
  }
}

TEST(HidDescriptor, AShortReportIsNotRead) {
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(example(), layout), Status::ok);
  const std::vector<std::uint8_t> cut = {0x01, 0x01, 0x03, 0x0C, 0x00, 0xDD, 0xFF, 0xE6};
  double v = 0;
  EXPECT_FALSE(read_hid_field(*field_of(layout, HidQuantity::acceleration, 2), 0, cut, v));
}

TEST(HidDescriptor, CutOrDamagedDescriptorsAreRefusedOrAtLeastHarmless) {
  const auto good = example();
  HidLayout layout;
  for (std::size_t n = 0; n + 1 < good.size(); ++n)
    EXPECT_NE(parse_hid_descriptor(std::span(good).first(n), layout), Status::ok) << n << " bytes";
  const unsigned seed = 3;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int trial = 0; trial < 5000; ++trial) {
    auto bad = good;
    for (int k = 0; k < 4; ++k) bad[random() % bad.size()] = static_cast<std::uint8_t>(random());
    (void)parse_hid_descriptor(bad, layout);
    std::array<std::uint8_t, 64> report{};
    double v = 0;
    for (const HidField& f : layout.fields)
      for (int e = 0; e < f.count; ++e) (void)read_hid_field(f, e, report, v);
    for (const HidFeature& f : layout.features) (void)make_feature_report(f, 5, report);
  }
}

}  // namespace
}  // namespace sanso::firmware
