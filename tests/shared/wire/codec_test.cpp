// The bytes of every message: fixed layout, exact length, and rejection of everything that is not
// exactly a message.
#include "shared/wire/codec.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace sanso::wire {
namespace {

template <class Message>
std::vector<std::uint8_t> bytes_of(const Message& message) {
  std::vector<std::uint8_t> buffer(kMaxDatagram);
  const Result<std::size_t> size = encode(message, buffer);
  EXPECT_TRUE(size.ok());
  buffer.resize(*size);
  return buffer;
}

Observation sample_observation() {
  Observation o;
  o.tick = 0x0102030405060708u;
  o.time = 123 * kMillisecond;
  o.trial_tick = -1;
  o.state = SupervisorState::run;
  o.fault = 17;
  o.limits = 0x80000001u;
  o.contact = 3;
  for (int i = 0; i < model::kNumJoints; ++i) {
    o.x[model::kXJoint + i] = 0.1 * i;
    o.current_raw[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(-100 + i);
    o.u_out[i] = -0.01 * i;
  }
  o.upper_weight = 0.5f;
  o.upper_age_ticks = -3;
  o.datagrams_dropped = 9;
  return o;
}

template <class Message>
class EveryMessage : public ::testing::Test {
 public:
  static Message sample();
};
template <>
Command EveryMessage<Command>::sample() {
  return {7, CommandKind::start_trial, 3, policy::LayerSwitches::kAll, 590, 12345};
}
template <>
CommandAck EveryMessage<CommandAck>::sample() {
  return {7, 1, SupervisorState::hold, 40};
}
template <>
Observation EveryMessage<Observation>::sample() {
  return sample_observation();
}
template <>
UploadChunk EveryMessage<UploadChunk>::sample() {
  UploadChunk c;
  c.kind = UploadKind::middle_table;
  c.upload_id = 4;
  c.total_bytes = kChunkPayload + 3;
  c.checksum = 0xCBF43926u;
  c.index = 1;
  c.count = 2;
  for (const std::uint8_t b : {1, 2, 3}) c.payload.try_push(b);
  return c;
}
template <>
UploadAck EveryMessage<UploadAck>::sample() {
  return {UploadKind::upper_policy, 5, 1, 0, 0, 6};
}

using Messages = ::testing::Types<Command, CommandAck, Observation, UploadChunk, UploadAck>;
TYPED_TEST_SUITE(EveryMessage, Messages);

TYPED_TEST(EveryMessage, SurvivesTheRoundTrip) {
  const auto bytes = bytes_of(TestFixture::sample());
  TypeParam back;
  ASSERT_EQ(decode(bytes, back), Status::ok);
  EXPECT_EQ(bytes_of(back), bytes);
}

TYPED_TEST(EveryMessage, EveryOtherLengthIsMalformed) {
  auto bytes = bytes_of(TestFixture::sample());
  TypeParam out;
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_EQ(decode(Bytes(bytes).first(n), out), Status::malformed) << n << " bytes";
  bytes.push_back(0);
  EXPECT_EQ(decode(bytes, out), Status::malformed);
}

TYPED_TEST(EveryMessage, OtherVersionIsUnsupportedAndOtherTypeMalformed) {
  const auto bytes = bytes_of(TestFixture::sample());
  TypeParam out;
  for (int v = 0; v < 256; ++v) {
    auto changed = bytes;
    changed[0] = static_cast<std::uint8_t>(v);
    if (v != kProtocolVersion) {
      EXPECT_EQ(decode(changed, out), Status::unsupported);
    }
    changed = bytes;
    changed[1] = static_cast<std::uint8_t>(v);
    if (v != bytes[1]) {
      EXPECT_EQ(decode(changed, out), Status::malformed);
    }
  }
}

TYPED_TEST(EveryMessage, OneByteTooFewOfBuffer_ReportsFull) {
  const auto bytes = bytes_of(TestFixture::sample());
  std::vector<std::uint8_t> small(bytes.size() - 1);
  EXPECT_EQ(encode(TestFixture::sample(), small).status(), Status::full);
}

TEST(WireCodec, CommandHasTheseBytes) {
  const std::vector<std::uint8_t> expected = {2,    5,    7, 0, 0,    0,    2, 3, 0, 0, 0, 15,
                                              0x4E, 0x02, 0, 0, 0x39, 0x30, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(
      bytes_of(Command{7, CommandKind::start_trial, 3, policy::LayerSwitches::kAll, 590, 12345}),
      expected);
}

TEST(WireCodec, TheQuestionInTheClearIsAsLongAsItsAnswer) {
  std::array<std::uint8_t, kIdentityBytes> who{}, answer{};
  encode_who(who);
  EXPECT_TRUE(is_who(who));
  who[0] = 77;
  EXPECT_TRUE(is_who(who)) << "whatever the version";
  EXPECT_FALSE(is_who(std::span(who).first(kIdentityBytes - 1)));
  Identity identity, read;
  identity.robot_name = {'o', 'p', '3', '\n'};
  encode_identity(identity, answer);
  ASSERT_EQ(decode_identity(answer, read), Status::ok);
  EXPECT_STREQ(read.robot_name.data(), "op3") << "what a terminal might obey does not get through";
  EXPECT_EQ(read.protocol_version, kProtocolVersion);
  EXPECT_NE(decode_identity(who, read), Status::ok);
}

TEST(WireCodec, ObservationKeepsEveryField) {
  const Observation o = sample_observation();
  Observation back;
  ASSERT_EQ(decode(bytes_of(o), back), Status::ok);
  EXPECT_EQ(back.tick, o.tick);
  EXPECT_EQ(back.time, o.time);
  EXPECT_EQ(back.trial_tick, -1);
  EXPECT_EQ(back.state, SupervisorState::run);
  EXPECT_EQ(back.fault, 17);
  EXPECT_EQ(back.limits, 0x80000001u);
  EXPECT_EQ(back.x, o.x);
  EXPECT_EQ(back.current_raw, o.current_raw);
  EXPECT_EQ(back.u_out, o.u_out);
  EXPECT_EQ(back.upper_age_ticks, -3);
  EXPECT_EQ(back.datagrams_dropped, 9u);
}

TEST(WireCodec, ObservationFitsADatagramAfterSealing) {
  EXPECT_LE(bytes_of(Observation{}).size() + 24, kMaxDatagram);
}

TEST(WireCodec, NumbersThatAreNotFiniteAreRejected) {
  Observation out;
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Observation o = sample_observation();
    o.x[model::kXJoint] = bad;
    EXPECT_EQ(decode(bytes_of(o), out), Status::malformed);
  }
}

TEST(WireCodec, ValuesOutsideTheirRangeAreRejectedAndLeaveTheOutputAlone) {
  Command command = EveryMessage<Command>::sample();
  Command out;
  out.sequence = 99;
  command.layers = 16;
  EXPECT_EQ(decode(bytes_of(command), out), Status::malformed);
  command.layers = 15;
  command.duration_ticks = -1;
  EXPECT_EQ(decode(bytes_of(command), out), Status::malformed);
  command.duration_ticks = 0;
  command.kind = static_cast<CommandKind>(8);
  EXPECT_EQ(decode(bytes_of(command), out), Status::malformed);
  EXPECT_EQ(out.sequence, 99u);

  Observation o = sample_observation();
  o.x[model::kXQuat] = 1.1;
  Observation observation_out;
  EXPECT_EQ(decode(bytes_of(o), observation_out), Status::malformed);
}

TEST(WireCodec, ChunkWithContradictingCountsIsRejected) {
  const UploadChunk good = EveryMessage<UploadChunk>::sample();
  UploadChunk out;
  UploadChunk bad = good;
  bad.count = 3;
  EXPECT_EQ(decode(bytes_of(bad), out), Status::malformed);
  bad = good;
  bad.index = 2;
  EXPECT_EQ(decode(bytes_of(bad), out), Status::malformed);
  bad = good;
  bad.index = 0;  // the first piece must be full
  EXPECT_EQ(decode(bytes_of(bad), out), Status::malformed);
  bad = good;
  bad.total_bytes = 0;
  EXPECT_EQ(decode(bytes_of(bad), out), Status::malformed);
}

}  // namespace
}  // namespace sanso::wire
