// Text and bytes as other programs take them inside a text: gzip streams and base64.
#pragma once

#include <string>
#include <string_view>

namespace sanso::report {

/// A gzip stream of the bytes. Throws std::runtime_error when zlib has no memory.
std::string gzip(std::string_view bytes);
std::string base64(std::string_view bytes);

}  // namespace sanso::report
