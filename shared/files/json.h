// JSON that a program stored for itself or for another one to read.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::files {

/// What the file holds; null where there is none or where it is not JSON: half written, say. For
/// callers that say themselves what they miss in it.
template <class Json = nlohmann::json>
Json json_or_null(const std::filesystem::path& path) {
  try {
    Json read = Json::parse(read_file(path), nullptr, false);
    return read.is_discarded() ? Json() : read;
  } catch (const InputError&) {
    return Json();
  }
}

/// What the file holds. Throws InputError.
template <class Json = nlohmann::json>
Json read_json(const std::filesystem::path& path) {
  Json read = Json::parse(read_file(path), nullptr, false);
  if (read.is_discarded())
    throw InputError(path.string(), 0, "", "not JSON", "", "a file that was written to its end");
  return read;
}

}  // namespace sanso::files
