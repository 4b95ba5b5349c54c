// The HID sensor descriptor: layout found, bytes scaled, nonsense refused.
#include "firmware/imu/hid_descriptor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "firmware/imu/hid_description.h"
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

/// One report (no ID) with three accelerations and three rates, named by usage ranges; the unit
/// exponent of the first is pushed away for the second, and a feature report with a byte of the
/// maker's own before the reporting state.
const std::vector<std::uint8_t> kRanges = {
    0x05, 0x20, 0x09, 0x01, 0xA1, 0x01,              // sensors, application
    0x16, 0x01, 0x80, 0x26, 0xFF, 0x7F,              // logical -32767 .. 32767
    0x75, 0x10, 0x95, 0x03,                          // 3 x 16 bit
    0x55, 0x0D,                                      // exponent -3
    0x1A, 0x53, 0x04, 0x2A, 0x55, 0x04, 0x81, 0x02,  // acceleration x .. z
    0xA4, 0x55, 0x0E,                                // push; exponent -2
    0x1A, 0x57, 0x04, 0x2A, 0x59, 0x04, 0x81, 0x02,  // angular velocity x .. z
    0xB4,                                            // pop: exponent -3 again
    0x0A, 0x53, 0x14, 0x95, 0x01, 0x81, 0x02,        // a modifier: no motion data
    0x15, 0x00, 0x25, 0x05, 0x75, 0x08, 0x95, 0x01,  // 1 x 8 bit
    0x06, 0x00, 0xFF, 0x09, 0x01, 0xB1, 0x02,        // the maker's own feature byte
    0x05, 0x20, 0x0A, 0x16, 0x03, 0xA1, 0x02,        // reporting state
    0x1A, 0x40, 0x08, 0x2A, 0x45, 0x08, 0xB1, 0x00,  // its selectors as a range
    0xC0, 0xC0};

TEST(HidDescriptor, UsageRangesPushAndPopAndReportsWithoutNumbers) {
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(kRanges, layout), Status::ok);
  ASSERT_EQ(layout.fields.size(), 6u);
  // 1000 counts of 1e-3 g on z; -250 counts of 1e-2 deg/s about y
  const std::vector<std::uint8_t> report = {0, 0, 0, 0, 0xE8, 0x03, 0, 0, 0x06, 0xFF, 0, 0};
  EXPECT_NEAR(value_of(layout, HidQuantity::acceleration, 2, 0, report), 9.80665, 1e-9);
  EXPECT_NEAR(value_of(layout, HidQuantity::angular_velocity, 1, 0, report),
              -2.5 * 0.0174532925199433, 1e-9);
}

TEST(HidDescriptor, AFeatureReportKeepsWhatIsNotOurs) {
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(kRanges, layout), Status::ok);
  ASSERT_EQ(layout.features.size(), 1u);
  std::array<std::uint8_t, 8> report = {0, 0xA5, 0xFF};  // as read: 0, the maker's byte, state
  ASSERT_EQ(make_feature_report(layout.features[0], 5, report), 3u);
  EXPECT_EQ(report[0], 0x00) << "reports without numbers travel with a leading 0";
  EXPECT_EQ(report[1], 0xA5);
  EXPECT_EQ(report[2], 0x01) << "all events is the second selector";
}

TEST(HidDescriptor, SelectorsThatBeginAtTheLargestNumberAreHarmless) {
  std::vector<std::uint8_t> bytes(std::begin(kRanges), std::end(kRanges));
  const std::array<std::uint8_t, 3> range = {0x1A, 0x40, 0x08};
  const auto at = std::search(bytes.begin(), bytes.end(), range.begin(), range.end());
  ASSERT_NE(at, bytes.end());
  const std::array<std::uint8_t, 5> largest = {0x17, 0xFF, 0xFF, 0xFF, 0x7F};  // logical minimum
  bytes.insert(at, largest.begin(), largest.end());
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(bytes, layout), Status::ok);
  EXPECT_EQ(layout.features[0].all_events_raw, 0) << "the second selector, in a byte";
}

TEST(HidDescriptor, APopWithoutAPushIsMalformed) {
  HidLayout layout;
  EXPECT_EQ(parse_hid_descriptor(std::vector<std::uint8_t>{0x05, 0x20, 0xB4}, layout),
            Status::malformed);
}

// the boot keyboard of USB HID 1.11, appendix E.6
const std::vector<std::uint8_t> kKeyboard = {
    0x05, 0x01, 0x09, 0x06, 0xA1, 0x01, 0x05, 0x07, 0x19, 0xE0, 0x29, 0xE7, 0x15, 0x00, 0x25,
    0x01, 0x75, 0x01, 0x95, 0x08, 0x81, 0x02, 0x95, 0x01, 0x75, 0x08, 0x81, 0x01, 0x95, 0x06,
    0x75, 0x08, 0x15, 0x00, 0x25, 0x65, 0x05, 0x07, 0x19, 0x00, 0x29, 0x65, 0x81, 0x00, 0xC0};

TEST(HidDescriptor, AKeyboardIsNamedFieldByField) {
  HidLayout layout;
  EXPECT_EQ(parse_hid_descriptor(kKeyboard, layout), Status::unsupported);
  const std::string why = why_no_imu(kKeyboard);
  for (const char* part : {"but a keyboard", "missing acceleration x y z angular velocity x y z",
                           "usage 0007:00E0 to usage 0007:00E7 (8 x 1 bit)",
                           "usage 0007:0000 to usage 0007:0065 (6 x 8 bit)"})
    EXPECT_NE(why.find(part), std::string::npos) << part << " not in:\n" << why;
  EXPECT_EQ(why_no_imu(example()), "");
}

TEST(HidDescriptor, AMakersOwnLayoutIsFoundByItsNumbers) {
  HidLayout layout;
  ASSERT_EQ(parse_hid_descriptor(kKeyboard, layout, {0x054C, 0x0CE6}), Status::ok);
  std::array<std::uint8_t, 64> report{};
  report[0] = 1;
  report[26] = 0x00;  // acceleration z, i16 from byte 26: 8192 counts are 1 g
  report[27] = 0x20;
  EXPECT_NEAR(value_of(layout, HidQuantity::acceleration, 2, 0, report), 9.80665, 1e-9);
}

}  // namespace
}  // namespace sanso::firmware
