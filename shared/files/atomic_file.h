// Files that are either the old or the new version, never half of one: written beside, flushed to
// the disk, renamed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sanso::files {

/// What stands beside a file while its new version is written.
constexpr std::string_view kUnfinished = ".new";

/// A file could not be written; what() names file, step, reason and what to do.
struct WriteError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Replaces `path` by `bytes`. A link stays a link: the file it names is replaced. A device or pipe
/// (/dev/stdout) is written to directly. Throws WriteError (a full disk, say); `path` is then as
/// before and nothing stands beside it.
void write_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_atomically(const std::filesystem::path& path, std::string_view text);

/// The whole file. Throws InputError.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path);
std::string read_text(const std::filesystem::path& path);

}  // namespace sanso::files
