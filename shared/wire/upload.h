// Blobs larger than a datagram: cut into pieces, put together again in fixed memory in any order,
// counted as whole only when the CRC-32 fits. What the blobs contain is the business of
// shared/policy.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "shared/base/crc32.h"
#include "shared/base/status.h"
#include "shared/wire/messages.h"

namespace sanso::wire {

/// Pieces that `total_bytes` need.
constexpr std::size_t chunk_count(std::size_t total_bytes) {
  return (total_bytes + kChunkPayload - 1) / kChunkPayload;
}

/// Piece `index` of `blob`. Needs index < chunk_count(blob.size()). `checksum` is crc32(blob),
/// computed once by the caller.
UploadChunk make_chunk(UploadKind kind, std::uint32_t upload_id, std::span<const std::uint8_t> blob,
                       std::uint32_t checksum, std::size_t index);

/// Puts the pieces of one upload together in memory that its maker owns. A piece with a new
/// upload_id starts over.
class UploadAssembler {
 public:
  /// `buffer` bounds the blob; `received` needs one byte for every piece of a full buffer.
  UploadAssembler(std::span<std::uint8_t> buffer, std::span<std::uint8_t> received)
      : buffer_(buffer), received_(received) {}

  /// ok: stored (or known already). full: the blob is larger than the buffer. malformed:
  /// contradicts its upload's first piece or its own counts. rejected: the last piece came and the
  /// checksum is wrong; everything is forgotten.
  Status accept(const UploadChunk& chunk);

  bool complete() const { return active_ && missing_ == 0; }
  /// Index of the first piece not yet here; the count of pieces when complete, 0 before the first.
  std::uint16_t first_missing() const;
  UploadKind kind() const { return kind_; }
  std::uint32_t upload_id() const { return upload_id_; }
  /// The whole blob. Needs complete().
  std::span<const std::uint8_t> blob() const { return buffer_.first(total_bytes_); }
  void reset() { active_ = false; }

 private:
  void begin(const UploadChunk& chunk);

  std::span<std::uint8_t> buffer_;
  std::span<std::uint8_t> received_;
  bool active_ = false;
  UploadKind kind_ = UploadKind::primitives;
  std::uint32_t upload_id_ = 0;
  std::uint32_t total_bytes_ = 0;
  std::uint32_t checksum_ = 0;
  std::uint16_t count_ = 0;
  std::uint16_t missing_ = 0;
};

/// An assembler together with its memory.
template <std::size_t Capacity>
class FixedUploadAssembler {
 public:
  FixedUploadAssembler() : assembler_(buffer_, received_) {}
  FixedUploadAssembler(const FixedUploadAssembler&) = delete;  // assembler_ points into this object
  FixedUploadAssembler& operator=(const FixedUploadAssembler&) = delete;
  UploadAssembler& operator*() { return assembler_; }
  UploadAssembler* operator->() { return &assembler_; }

 private:
  std::array<std::uint8_t, Capacity> buffer_{};
  std::array<std::uint8_t, chunk_count(Capacity)> received_{};
  UploadAssembler assembler_;
};

}  // namespace sanso::wire
