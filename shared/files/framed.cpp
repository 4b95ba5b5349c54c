// The frame: every byte of the file is covered by the checksum at its end.
#include "shared/files/framed.h"

#include "shared/base/crc32.h"
#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::files {
namespace {

constexpr std::size_t kHeader = 8 + sizeof(std::uint32_t) + sizeof(std::uint64_t);
constexpr std::size_t kFrame = kHeader + sizeof(std::uint32_t);

constexpr const char* kAgain = "another file; or delete it and run again";

[[noreturn]] void refuse(const std::string& name, const std::string& defect,
                         const std::string& found, const std::string& expected) {
  throw InputError(name, 0, "", defect, found, expected);
}

std::string_view characters(std::span<const std::uint8_t> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

void FramedReader::fail() const {
  refuse(name_, "ends too early", "byte " + std::to_string(at_) + " is its last", kAgain);
}

std::string_view FramedReader::take(std::size_t count) {
  if (count > left()) fail();
  at_ += count;
  return std::string_view(bytes_).substr(at_ - count, count);
}

void save_framed(const std::filesystem::path& path, const char (&magic)[9], std::uint32_t version,
                 std::span<const std::uint8_t> payload) {
  ByteWriter out;
  out.raw({magic, 8});
  out.number(version);
  out.number(static_cast<std::uint64_t>(payload.size()));
  out.raw(characters(payload));
  out.number(crc32(out.span()));
  write_atomically(path, out.bytes());
}

FramedReader load_framed(const std::filesystem::path& path, const char (&magic)[9],
                         std::uint32_t version) {
  const std::string name = path.string();
  const std::vector<std::uint8_t> bytes = read_file(path);
  ByteReader in(characters(bytes));
  if (bytes.size() < kFrame || in.take(8) != std::string_view(magic, 8))
    refuse(name, "not a file of kind " + std::string(magic, 8), "", kAgain);
  const auto found_version = in.number<std::uint32_t>();
  if (found_version != version)
    refuse(name, "another version", std::to_string(found_version), std::to_string(version));
  const auto size = in.number<std::uint64_t>();
  if (size != bytes.size() - kFrame)
    refuse(name, "cut or joined", std::to_string(bytes.size() - kFrame) + " bytes of content",
           std::to_string(size) + " as its header says; delete it and run again");
  const std::string_view payload = in.take(size);
  if (in.number<std::uint32_t>() != crc32(std::span(bytes).first(kHeader + size)))
    refuse(name, "damaged (checksum does not fit)", "", kAgain);
  return FramedReader(name, std::string(payload));
}

}  // namespace sanso::files
