// Files that are either the old or the new version, never half of one: written beside, flushed to
// the disk, renamed.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sanso::learn {

/// Replaces `path` by `bytes`. Throws std::runtime_error naming file and reason (a full disk, say);
/// `path` is then as before.
void write_atomically(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
void write_atomically(const std::filesystem::path& path, std::string_view text);

/// The whole file. Throws std::runtime_error naming file and reason.
std::vector<std::uint8_t> read_file(const std::filesystem::path& path);

}  // namespace sanso::learn
