// Where data that is not part of the repository lives. Tests that need it skip, and say so, when it
// is absent.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

namespace sanso::test {

/// $SANSO_DATA, or ../shared/data beside the repository (tests run in its root). Need not exist.
inline std::filesystem::path shared_data() {
  const char* set = std::getenv("SANSO_DATA");
  return set != nullptr ? std::filesystem::path(set) : std::filesystem::path("../shared/data");
}

}  // namespace sanso::test
