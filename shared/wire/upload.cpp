// Cuts a blob into chunks and assembles them in any order into a fixed buffer; repeated chunks
// are counted once.
#include "shared/wire/upload.h"

#include <algorithm>
#include <cassert>

namespace sanso::wire {

UploadChunk make_chunk(UploadKind kind, std::uint32_t upload_id, std::span<const std::uint8_t> blob,
                       std::uint32_t checksum, std::size_t index) {
  const std::size_t begin = index * kChunkPayload;
  assert(begin < blob.size());
  UploadChunk chunk;
  chunk.kind = kind;
  chunk.upload_id = upload_id;
  chunk.total_bytes = static_cast<std::uint32_t>(blob.size());
  chunk.checksum = checksum;
  chunk.index = static_cast<std::uint16_t>(index);
  chunk.count = static_cast<std::uint16_t>(chunk_count(blob.size()));
  (void)chunk.payload.try_append(blob.subspan(begin, std::min(kChunkPayload, blob.size() - begin)));
  return chunk;
}

void UploadAssembler::begin(const UploadChunk& chunk) {
  active_ = true;
  kind_ = chunk.kind;
  upload_id_ = chunk.upload_id;
  total_bytes_ = chunk.total_bytes;
  checksum_ = chunk.checksum;
  count_ = chunk.count;
  missing_ = chunk.count;
  std::fill_n(received_.begin(), count_, std::uint8_t{0});
}

Status UploadAssembler::accept(const UploadChunk& chunk) {
  if (chunk.total_bytes > buffer_.size() || chunk.count > received_.size()) return Status::full;
  const std::size_t at = static_cast<std::size_t>(chunk.index) * kChunkPayload;
  if (chunk.count != chunk_count(chunk.total_bytes) || chunk.index >= chunk.count ||
      chunk.payload.size() != std::min<std::size_t>(kChunkPayload, chunk.total_bytes - at))
    return Status::malformed;

  const bool same = active_ && chunk.kind == kind_ && chunk.upload_id == upload_id_;
  if (!same) begin(chunk);
  if (chunk.total_bytes != total_bytes_ || chunk.checksum != checksum_) return Status::malformed;
  if (received_[chunk.index]) return Status::ok;

  std::copy(chunk.payload.begin(), chunk.payload.end(),
            buffer_.begin() + static_cast<std::ptrdiff_t>(at));
  received_[chunk.index] = 1;
  --missing_;
  if (missing_ == 0 && crc32(blob()) != checksum_) {
    reset();
    return Status::rejected;
  }
  return Status::ok;
}

std::uint16_t UploadAssembler::first_missing() const {
  if (!active_) return 0;
  const auto end = received_.begin() + count_;
  return static_cast<std::uint16_t>(std::find(received_.begin(), end, std::uint8_t{0}) -
                                    received_.begin());
}

}  // namespace sanso::wire
