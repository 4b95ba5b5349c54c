#include "host/learn/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace sanso::learn {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* step, int error) {
  std::string message = path.string() + ": " + step + ": " + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT)
    message += "; free some space and run the same command again with --resume";
  throw std::runtime_error(message);
}

/// Closes the descriptor and removes the temporary file unless the write was finished.
struct TemporaryFile {
  std::filesystem::path path;
  int descriptor = -1;
  bool finished = false;
  ~TemporaryFile() {
    if (descriptor >= 0) ::close(descriptor);
    if (!finished) ::unlink(path.c_str());
  }
};

void write_all(const TemporaryFile& file, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file.descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(file.path, "cannot write", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

/// The rename itself reaches the disk with the directory.
void flush_directory(const std::filesystem::path& directory) {
  const int descriptor =
      ::open(directory.empty() ? "." : directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // not every file system lets one: the file itself is already safe
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

void write_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  TemporaryFile file;
  file.path = path;
  file.path += ".new";
  file.descriptor = ::open(file.path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file.descriptor < 0) fail(file.path, "cannot create", errno);
  write_all(file, bytes);
  if (::fsync(file.descriptor) != 0) fail(file.path, "cannot flush to the disk", errno);
  if (::rename(file.path.c_str(), path.c_str()) != 0) fail(path, "cannot replace", errno);
  file.finished = true;
  flush_directory(path.parent_path());
}

void write_atomically(const std::filesystem::path& path, std::string_view text) {
  write_atomically(path,
                   std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::vector<std::uint8_t> read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot open", errno);
  std::vector<std::uint8_t> bytes((std::istreambuf_iterator<char>(in)),
                                  std::istreambuf_iterator<char>());
  if (in.bad()) fail(path, "cannot read", errno);
  return bytes;
}

}  // namespace sanso::learn
