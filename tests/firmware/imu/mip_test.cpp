// MIP against the bytes of the maker's manual, noise, and orientations worked out by hand.
#include <gtest/gtest.h>

#include <bit>
#include <random>
#include <vector>

#include "firmware/imu/mip_reader.h"

namespace sanso::firmware {
namespace {

using ByteList = std::vector<std::uint8_t>;

// acceleration (0, 0, -1) g, rate (0.1, -0.2, 0.3) rad/s, identity quaternion; checksums as printed
const ByteList kPacket = {0x75, 0x65, 0x80, 0x2E, 0x0E, 0x04, 0x00, 0x00, 0x00, 0x00, 0x00,
                          0x00, 0x00, 0x00, 0xBF, 0x80, 0x00, 0x00, 0x0E, 0x05, 0x3D, 0xCC,
                          0xCC, 0xCD, 0xBE, 0x4C, 0xCC, 0xCD, 0x3E, 0x99, 0x99, 0x9A, 0x12,
                          0x0A, 0x3F, 0x80, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                          0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x16, 0xA5};

std::vector<MipSample> parse(const ByteList& bytes, MipParser& parser) {
  std::vector<MipSample> samples;
  parser.feed(bytes, [&](const MipSample& s) { samples.push_back(s); });
  return samples;
}

TEST(Mip, ReadsTheExamplePacketAlsoByteByByte) {
  MipParser parser;
  for (const std::uint8_t byte : kPacket) {
    const auto samples = parse({byte}, parser);
    if (samples.empty()) continue;
    ASSERT_TRUE(samples[0].accel && samples[0].gyro && samples[0].quat);
    EXPECT_NEAR((*samples[0].accel)[2], -9.80665, 1e-6);
    EXPECT_NEAR((*samples[0].gyro)[1], -0.2, 1e-6);
    EXPECT_EQ((*samples[0].quat)[0], 1.0);
    return;
  }
  FAIL() << "no sample";
}

TEST(Mip, MakesTheCommandsOfTheManual) {
  ByteList out(32);
  const ByteList format{0x0D, 0x08, 0x01, 0x03, 0x04, 0x00, 0x0A,
                        0x05, 0x00, 0x0A, 0x0A, 0x00, 0x0A};
  out.resize(make_mip_packet(0x0C, format, out));
  ASSERT_EQ(out.size(), 19u);
  EXPECT_EQ(out[17], 0x3D);
  EXPECT_EQ(out[18], 0x89);
}

TEST(Mip, DamageCostsThatPacketAlone) {
  std::mt19937 random(5);
  for (std::size_t at = 0; at < kPacket.size(); ++at) {
    MipParser parser;
    ByteList stream = kPacket;
    stream[at] = static_cast<std::uint8_t>(stream[at] ^ (1u << (random() % 8)));
    // a damaged length may swallow what follows; five more bring it back into step
    for (int i = 0; i < 6; ++i) stream.insert(stream.end(), kPacket.begin(), kPacket.end());
    const auto samples = parse(stream, parser);
    ASSERT_GE(samples.size(), 5u) << "byte " << at;
    EXPECT_LE(samples.size(), 6u) << "byte " << at;
    for (const MipSample& s : samples) EXPECT_NEAR((*s.gyro)[2], 0.3, 1e-6) << "byte " << at;
  }
}

class ListedPort : public board::SerialPort {
 public:
  Status write(board::Bytes data) override {
    if (gone) return Status::io_error;
    sent.insert(sent.end(), data.begin(), data.end());
    return Status::ok;
  }
  Result<std::size_t> read(board::Buffer out, Nanoseconds) override {
    if (gone) return Status::io_error;
    const std::size_t n = std::min(out.size(), coming.size());
    std::copy_n(coming.begin(), n, out.begin());
    coming.erase(coming.begin(), coming.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  }
  Status ready() override { return Status::ok; }
  ByteList sent, coming;
  bool gone = false;
};

class StillClock : public board::Clock {
 public:
  Nanoseconds now() override { return time; }
  Nanoseconds time = kSecond;
};

void put(ByteList& out, double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (int shift = 24; shift >= 0; shift -= 8)
    out.push_back(static_cast<std::uint8_t>(bits >> shift));
}

/// A packet as the device sends it for a body turned by `quat` (NED to body) at rest.
ByteList resting(const math::Quat& quat) {
  ByteList payload{14, 4};
  // specific force at rest is against gravity: -1 g along down
  const math::Vec3 force = math::rotation_matrix(quat) * math::Vec3(0, 0, -1);
  for (int i = 0; i < 3; ++i) put(payload, force[i]);
  payload.insert(payload.end(), {14, 5});
  for (int i = 0; i < 3; ++i) put(payload, 0.0);
  payload.insert(payload.end(), {18, 10});
  for (int i = 0; i < 4; ++i) put(payload, quat[i]);
  ByteList packet(64);
  packet.resize(make_mip_packet(0x80, payload, packet));
  return packet;
}

struct Rig {
  ListedPort port;
  StillClock clock;
  Mailbox<ImuSample> out;
  MipReader reader{ImuSettings{}, port, clock, out};
};

TEST(Mip, AnyTiltAgreesWithGravityInOurFrames) {
  for (const math::Vec3& turn : {math::Vec3(0, 0, 0), math::Vec3(0.3, 0, 0), math::Vec3(0, 0.4, 0),
                                 math::Vec3(0.2, -0.5, 0.1), math::Vec3(1.0, 0.2, -2.0)}) {
    Rig rig;
    rig.port.coming = resting(math::quat_exp(turn));
    ASSERT_EQ(rig.reader.poll(0), Status::ok);
    ASSERT_TRUE(rig.out.update());
    const ImuSample& s = rig.out.front();
    const math::Vec3 up = math::rotation_matrix(s.quat_world_base) * s.accel;
    EXPECT_LT((up - math::Vec3(0, 0, 9.80665)).norm(), 1e-5);
  }
}

TEST(Mip, NoseUpIsNegativePitchInOurFrames) {
  Rig rig;
  // NED: a positive turn about y (right) lifts the nose; NED to body is its inverse
  rig.port.coming = resting(math::quat_exp({0, -0.3, 0}));
  ASSERT_EQ(rig.reader.poll(0), Status::ok);
  ASSERT_TRUE(rig.out.update());
  EXPECT_GT(rig.out.front().accel[0], 2.5) << "nose up: gravity's reaction points forward";
  EXPECT_NEAR((rig.out.front().quat_world_base - math::quat_exp({0, -0.3, 0})).norm(), 0, 1e-6);
}

TEST(Mip, AsksAgainAfterAnUnplug) {
  Rig rig;
  ASSERT_EQ(rig.reader.poll(0), Status::ok);
  const std::size_t asked = rig.port.sent.size();
  EXPECT_GT(asked, 0u);
  rig.port.gone = true;
  EXPECT_EQ(rig.reader.poll(0), Status::io_error);
  rig.port.gone = false;
  EXPECT_EQ(rig.reader.poll(0), Status::ok);
  EXPECT_EQ(rig.port.sent.size(), 2 * asked);
}

}  // namespace
}  // namespace sanso::firmware
