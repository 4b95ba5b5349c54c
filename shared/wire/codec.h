// Bytes of the messages in messages.h: fixed little-endian layout, protocol version and message
// type first.
// A decoder accepts exactly what an encoder makes: right version and type, right length, every
// number finite, every enumerator known, every value in its range. docs/wire.md lists the fields.
#pragma once

#include <span>

#include "shared/base/status.h"
#include "shared/wire/messages.h"

namespace sanso::wire {

using Bytes = std::span<const std::uint8_t>;
using Buffer = std::span<std::uint8_t>;

/// Version and type of a message; unsupported when the version is not ours, malformed when shorter
/// than two bytes or of an unknown type.
Result<MessageType> message_type(Bytes data);

/// Number of bytes written, or `full` when the buffer is too small. Every message fits 1400 bytes
/// after sealing.
Result<std::size_t> encode(const Command& message, Buffer buffer);
Result<std::size_t> encode(const CommandAck& message, Buffer buffer);
Result<std::size_t> encode(const Observation& message, Buffer buffer);
Result<std::size_t> encode(const UploadChunk& message, Buffer buffer);
Result<std::size_t> encode(const UploadAck& message, Buffer buffer);

/// ok, malformed or unsupported; `out` changes only when ok.
Status decode(Bytes data, Command& out);
Status decode(Bytes data, CommandAck& out);
Status decode(Bytes data, Observation& out);
Status decode(Bytes data, UploadChunk& out);
Status decode(Bytes data, UploadAck& out);

// Not sealed: version | type | ... The question is as long as the answer, so that nobody can be
// flooded through a controller.
inline constexpr std::size_t kIdentityBytes = 35;
void encode_who(std::span<std::uint8_t, kIdentityBytes> out);
/// A question of any protocol version.
bool is_who(Bytes data);
void encode_identity(const Identity& identity, std::span<std::uint8_t, kIdentityBytes> out);
/// malformed: something else.
Status decode_identity(Bytes data, Identity& out);

}  // namespace sanso::wire
