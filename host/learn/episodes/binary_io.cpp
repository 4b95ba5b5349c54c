// Bytes are checked as a whole (name, version, length, checksum) before a single field is read.
#include "host/learn/episodes/binary_io.h"

#include <zlib.h>

#include <bit>

#include "host/learn/atomic_file.h"

namespace sanso::learn {

static_assert(std::endian::native == std::endian::little,
              "the files are little-endian; add byte swaps for this machine");

namespace {

std::uint32_t checksum(const std::uint8_t* data, std::size_t size) {
  return static_cast<std::uint32_t>(crc32_z(0, data, size));
}

constexpr std::size_t kHeader = 8 + sizeof(std::uint32_t) + sizeof(std::uint64_t);

}  // namespace

void save_framed(const std::filesystem::path& path, const char (&magic)[9], std::uint32_t version,
                 const std::vector<std::uint8_t>& payload) {
  BinaryWriter out;
  for (int i = 0; i < 8; ++i) out.put(magic[i]);
  out.put(version);
  out.put(static_cast<std::uint64_t>(payload.size()));
  std::vector<std::uint8_t> bytes = out.bytes();
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  BinaryWriter tail;
  tail.put(checksum(bytes.data(), bytes.size()));
  bytes.insert(bytes.end(), tail.bytes().begin(), tail.bytes().end());
  write_atomically(path, bytes);
}

BinaryReader load_framed(const std::filesystem::path& path, const char (&magic)[9],
                         std::uint32_t version) {
  std::vector<std::uint8_t> bytes = read_file(path);
  const std::string name = path.string();
  if (bytes.size() < kHeader + 4 || std::memcmp(bytes.data(), magic, 8) != 0)
    throw std::runtime_error(name + ": not a file of kind " + std::string(magic, 8));
  std::uint32_t found_version = 0, stored = 0;
  std::uint64_t size = 0;
  std::memcpy(&found_version, bytes.data() + 8, sizeof found_version);
  std::memcpy(&size, bytes.data() + 12, sizeof size);
  if (found_version != version)
    throw std::runtime_error(name + ": version " + std::to_string(found_version) +
                             ", this program reads " + std::to_string(version));
  if (size != bytes.size() - kHeader - 4)
    throw std::runtime_error(name + ": " + std::to_string(bytes.size() - kHeader - 4) +
                             " bytes of content, header says " + std::to_string(size));
  std::memcpy(&stored, bytes.data() + bytes.size() - 4, sizeof stored);
  if (stored != checksum(bytes.data(), bytes.size() - 4))
    throw std::runtime_error(name + ": damaged (checksum does not fit); delete it and run again");
  return BinaryReader(name, {bytes.begin() + kHeader, bytes.end() - 4});
}

}  // namespace sanso::learn
