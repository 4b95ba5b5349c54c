// Writing beside and renaming with POSIX calls, because only they flush to the disk.
#include "shared/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "shared/files/input_error.h"

namespace sanso::files {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const char* step, int error) {
  std::string message = path.string() + ": " + step + ": " + std::strerror(error);
  if (error == ENOSPC || error == EDQUOT)
    message += "; free some space and run the same command again (a session: with --resume)";
  if (error == EACCES || error == EROFS || error == ENOENT || error == ENOTDIR)
    message += "; expected a file in a folder that exists and may be written";
  throw WriteError(message);
}

[[noreturn]] void refuse(const fs::path& path, const char* defect) {
  throw InputError(path.string(), 0, "", defect, std::strerror(errno), "a readable file");
}

/// Closes the descriptor and removes the temporary file unless the write was finished.
struct OpenFile {
  int descriptor = -1;
  fs::path temporary = {};  // empty: there is none
  ~OpenFile() {
    if (descriptor >= 0) ::close(descriptor);
    if (!temporary.empty()) ::unlink(temporary.c_str());
  }
};

void write_all(int descriptor, const fs::path& path, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(path, "cannot write", errno);
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
}

/// The rename itself reaches the disk with the folder.
void flush_folder(const fs::path& folder) {
  const int descriptor =
      ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;  // not every file system lets one: the file itself is already safe
  ::fsync(descriptor);
  ::close(descriptor);
}

/// A rename would put an ordinary file in the place of these.
bool must_be_written_directly(const fs::path& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

/// The file behind `path` when it is a link to one.
fs::path behind_links(const fs::path& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target;
}

}  // namespace

void write_atomically(const fs::path& path, std::span<const std::uint8_t> bytes) {
  OpenFile file;
  if (must_be_written_directly(path)) {
    file.descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (file.descriptor < 0) fail(path, "cannot open", errno);
    return write_all(file.descriptor, path, bytes);
  }
  const fs::path target = behind_links(path);
  fs::path beside = target;
  beside += kUnfinished;
  file.descriptor = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file.descriptor < 0) fail(path, "cannot create", errno);
  file.temporary = beside;
  write_all(file.descriptor, path, bytes);
  if (::fsync(file.descriptor) != 0) fail(path, "cannot flush to the disk", errno);
  if (::rename(beside.c_str(), target.c_str()) != 0) fail(path, "cannot replace", errno);
  file.temporary.clear();
  flush_folder(target.parent_path());
}

void write_atomically(const fs::path& path, std::string_view text) {
  write_atomically(path,
                   std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::vector<std::uint8_t> read_file(const fs::path& path) {
  OpenFile file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.descriptor < 0) refuse(path, "cannot open");
  std::vector<std::uint8_t> bytes;
  std::size_t size = 0;
  while (true) {
    if (bytes.size() == size) bytes.resize(2 * size + (1u << 16));
    const ssize_t n = ::read(file.descriptor, bytes.data() + size, bytes.size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) refuse(path, "cannot read");
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
  }
  bytes.resize(size);
  return bytes;
}

std::string read_text(const fs::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  return {bytes.begin(), bytes.end()};
}

}  // namespace sanso::files
