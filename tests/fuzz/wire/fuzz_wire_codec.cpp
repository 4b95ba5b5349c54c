// Whatever arrives: it decodes or not, and what decodes encodes to the same bytes again.
#include <algorithm>
#include <array>
#include <cstdlib>

#include "shared/base/pose_report.h"
#include "shared/wire/codec.h"
#include "shared/wire/upload.h"

namespace {

using namespace sanso;

template <class Message>
bool round_trip(wire::Bytes data) {
  Message message;
  if (wire::decode(data, message) != Status::ok) return false;
  std::array<std::uint8_t, wire::kMaxDatagram> again;
  const Result<std::size_t> n = wire::encode(message, again);
  if (!n.ok() || *n != data.size() || !std::equal(data.begin(), data.end(), again.begin()))
    std::abort();
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const wire::Bytes data(bytes, size);
  if (size > wire::kMaxDatagram) return 0;
  round_trip<wire::Command>(data);
  round_trip<wire::CommandAck>(data);
  round_trip<wire::Observation>(data);
  round_trip<wire::UploadAck>(data);
  if (round_trip<wire::UploadChunk>(data)) {
    static wire::FixedUploadAssembler<8 * wire::kChunkPayload> assembler;
    wire::UploadChunk chunk;
    (void)wire::decode(data, chunk);
    const bool taken = assembler->accept(chunk) == Status::ok;
    if (taken && assembler->complete() && crc32(assembler->blob()) != chunk.checksum) std::abort();
    (void)assembler->first_missing();
  }
  (void)decode_pose_report(data);
  return 0;
}
