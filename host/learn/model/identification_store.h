// A stopped identification on disk: where its search stood, and of which search it is.
#pragma once

#include <cstdint>
#include <filesystem>

#include "host/learn/model/cross_entropy.h"

namespace sanso::learn {

/// `fingerprint` tells searches apart: of the recordings, the seed and all settings that change its
/// numbers.
void save_search(const std::filesystem::path& path, const CrossEntropyState& state,
                 std::uint64_t fingerprint);

/// Throws std::runtime_error when the file is missing, damaged, or of another search.
CrossEntropyState load_search(const std::filesystem::path& path, std::uint64_t fingerprint);

}  // namespace sanso::learn
