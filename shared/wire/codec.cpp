// One layout function a message, used for writing and for reading, so that both directions
// cannot differ.
#include "shared/wire/codec.h"

#include <algorithm>
#include <cmath>

#include "shared/base/byte_io.h"

namespace sanso::wire {
namespace {

// --- building blocks -----------------------------------------------------------------------------

template <class Archive, class Vector>
void each(Archive& ar, Vector& values) {
  for (auto& v : values) ar(v);
}

template <class Archive, class Vector>
void eigen(Archive& ar, Vector& values) {
  for (int i = 0; i < values.size(); ++i) ar(values[i]);
}

template <class Archive>
void require(Archive& ar, bool condition) {
  if constexpr (Archive::kReads) ar.require(condition);
}

template <class Archive, class Enum>
void enumerator(Archive& ar, Enum& value, std::uint8_t lowest, std::uint8_t highest) {
  ar(value);
  require(ar, static_cast<std::uint8_t>(value) >= lowest &&
                  static_cast<std::uint8_t>(value) <= highest);
}

template <class Archive, class Flag>
void flag(Archive& ar, Flag& value) {
  ar(value);
  require(ar, value <= 1);
}

template <class Archive, class State>
void state(Archive& ar, State& x) {
  eigen(ar, x);
  require(ar, std::abs(x.template segment<4>(model::kXQuat).norm() - 1.0) < 1e-3);
}

// --- the layouts: one function a message, in the order of messages.h -----------------------------

template <class Archive>
void layout(Archive& ar, typename Archive::template Ref<Command> m) {
  ar(m.sequence);
  enumerator(ar, m.kind, 0, 7);
  ar(m.trial_id);
  ar(m.layers);
  require(ar, m.layers <= policy::LayerSwitches::kAll);
  ar(m.duration_ticks);
  require(ar, m.duration_ticks >= 0);
  ar(m.observed_tick);
}

template <class Archive>
void layout(Archive& ar, typename Archive::template Ref<CommandAck> m) {
  ar(m.sequence);
  flag(ar, m.accepted);
  enumerator(ar, m.state, 0, 7);
  ar(m.reason);
}

template <class Archive>
void layout(Archive& ar, typename Archive::template Ref<Observation> m) {
  ar(m.tick);
  ar(m.time);
  ar(m.trial_tick);
  ar(m.trial_id);
  enumerator(ar, m.state, 0, 7);
  ar(m.fault);
  ar(m.limits);
  ar(m.contact);
  require(ar, m.contact <= 3);
  ar(m.pose_age_ticks);
  state(ar, m.x);
  each(ar, m.current_raw);
  each(ar, m.imu_acc);
  each(ar, m.imu_gyro);
  ar(m.voltage_V);
  ar(m.max_temperature_C);
  ar(m.upper_sequence);
  ar(m.upper_age_ticks);
  ar(m.upper_weight);
  require(ar, m.upper_weight >= 0.0f && m.upper_weight <= 1.0f);
  eigen(ar, m.u_upper);
  eigen(ar, m.u_middle);
  eigen(ar, m.u_lower);
  eigen(ar, m.u_out);
  ar(m.tick_cpu_ns);
  ar(m.late_ticks);
  ar(m.bus_lost);
  ar(m.bus_corrupt);
  ar(m.datagrams_dropped);
}

/// Length that piece `index` of `total_bytes` must have.
std::size_t piece_length(std::uint32_t total_bytes, std::uint16_t index) {
  const std::size_t begin = static_cast<std::size_t>(index) * kChunkPayload;
  const std::size_t left = begin < total_bytes ? total_bytes - begin : 0;
  return left < kChunkPayload ? left : kChunkPayload;
}

bool consistent(const UploadChunk& m) {
  const std::size_t count =
      (static_cast<std::size_t>(m.total_bytes) + kChunkPayload - 1) / kChunkPayload;
  return m.total_bytes > 0 && m.count == count && m.index < m.count &&
         m.payload.size() == piece_length(m.total_bytes, m.index);
}

template <class Archive>
void layout(Archive& ar, typename Archive::template Ref<UploadChunk> m) {
  enumerator(ar, m.kind, 1, 3);
  ar(m.upload_id);
  ar(m.total_bytes);
  ar(m.checksum);
  ar(m.index);
  ar(m.count);
  std::uint16_t length = static_cast<std::uint16_t>(m.payload.size());
  ar(length);
  if constexpr (Archive::kReads) {
    m.payload.clear();
    if (!m.payload.try_append(ar.bytes(length))) ar.reject();
    ar.require(consistent(m));
  } else {
    ar.bytes(m.payload.view());
  }
}

template <class Archive>
void layout(Archive& ar, typename Archive::template Ref<UploadAck> m) {
  enumerator(ar, m.kind, 1, 3);
  ar(m.upload_id);
  flag(ar, m.complete);
  flag(ar, m.refused);
  ar(m.reason);
  ar(m.first_missing);
}

// --- frame ---------------------------------------------------------------------------------------

template <class Message>
Result<std::size_t> encode_as(MessageType type, const Message& message, Buffer buffer) {
  ByteWriter writer(buffer);
  writer(kProtocolVersion);
  writer(type);
  layout(writer, message);
  if (!writer.ok()) return Status::full;
  return writer.size();
}

template <class Message>
Status decode_as(MessageType expected, Bytes data, Message& out) {
  const Result<MessageType> type = message_type(data);
  if (!type.ok()) return type.status();
  if (*type != expected) return Status::malformed;
  ByteReader reader(data.subspan(2));
  Message message;
  layout(reader, message);
  if (!reader.finished()) return Status::malformed;
  out = message;
  return Status::ok;
}

}  // namespace

Result<MessageType> message_type(Bytes data) {
  if (data.size() < 2) return Status::malformed;
  if (data[0] != kProtocolVersion) return Status::unsupported;
  if (data[1] < static_cast<std::uint8_t>(MessageType::hello) ||
      data[1] > static_cast<std::uint8_t>(MessageType::command_ack))
    return Status::malformed;
  return static_cast<MessageType>(data[1]);
}

Result<std::size_t> encode(const Command& m, Buffer buffer) {
  return encode_as(MessageType::command, m, buffer);
}
Result<std::size_t> encode(const CommandAck& m, Buffer buffer) {
  return encode_as(MessageType::command_ack, m, buffer);
}
Result<std::size_t> encode(const Observation& m, Buffer buffer) {
  return encode_as(MessageType::observation, m, buffer);
}
Result<std::size_t> encode(const UploadChunk& m, Buffer buffer) {
  return encode_as(MessageType::upload_chunk, m, buffer);
}
Result<std::size_t> encode(const UploadAck& m, Buffer buffer) {
  return encode_as(MessageType::upload_ack, m, buffer);
}

Status decode(Bytes data, Command& out) { return decode_as(MessageType::command, data, out); }
Status decode(Bytes data, CommandAck& out) {
  return decode_as(MessageType::command_ack, data, out);
}
Status decode(Bytes data, Observation& out) {
  return decode_as(MessageType::observation, data, out);
}
Status decode(Bytes data, UploadChunk& out) {
  return decode_as(MessageType::upload_chunk, data, out);
}
Status decode(Bytes data, UploadAck& out) { return decode_as(MessageType::upload_ack, data, out); }

// --- in the clear --------------------------------------------------------------------------------

void encode_who(std::span<std::uint8_t, kIdentityBytes> out) {
  std::fill(out.begin(), out.end(), std::uint8_t{0});
  out[0] = kProtocolVersion;
  out[1] = static_cast<std::uint8_t>(MessageType::who);
}

bool is_who(Bytes data) {
  return data.size() == kIdentityBytes && data[1] == static_cast<std::uint8_t>(MessageType::who);
}

void encode_identity(const Identity& identity, std::span<std::uint8_t, kIdentityBytes> out) {
  out[0] = kProtocolVersion;
  out[1] = static_cast<std::uint8_t>(MessageType::i_am);
  out[2] = identity.protocol_version;
  std::copy(identity.robot_name.begin(), identity.robot_name.end(), out.begin() + 3);
}

Status decode_identity(Bytes data, Identity& out) {
  if (data.size() != kIdentityBytes || data[1] != static_cast<std::uint8_t>(MessageType::i_am))
    return Status::malformed;
  out.protocol_version = data[2];
  for (std::size_t i = 0; i < out.robot_name.size(); ++i) {
    const char c = static_cast<char>(data[3 + i]);
    out.robot_name[i] = c >= ' ' && c <= '~' ? c : '\0';
  }
  return Status::ok;
}

}  // namespace sanso::wire
