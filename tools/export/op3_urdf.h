// The emulated robot as a URDF, for programs that show recordings: links with the maker's masses,
// joints, and the primitives that the emulated robot collides with.
#pragma once

#include <string>

namespace sanso::exports {

std::string op3_urdf();

}  // namespace sanso::exports
