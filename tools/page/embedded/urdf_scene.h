// What the page draws of any robot: the links of its URDF with the URDF's own shapes, meshes
// included.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace sanso::page {

/// {"links": [{"name", "parent": place in the list (-1: none), "pos" [m], "quat" (w x y z),
/// "joint": {"name", "axis", "slides"} (absent: fixed), "com" [m, link axes], "shapes": [...]}],
/// "notes": [text]}. Parents come before children. A shape is {"type", "pos", "quat"} and "size"
/// (box), "radius" (sphere), "radius" and "length" (cylinder along z) or "stl" (base64) with
/// "scale". A link without visuals has its collision shapes; one without either has none, and the
/// page draws a bar to what it carries. Meshes are read beside `folder`; those that are no STL, are
/// not there, or go beyond `most_mesh_bytes` in all, stand in "notes".
/// Throws files::InputError for text that is no URDF; `file` is named there.
nlohmann::json scene_of_urdf(const std::string& urdf, const std::string& file,
                             const std::filesystem::path& folder,
                             std::size_t most_mesh_bytes = 1'500'000);

}  // namespace sanso::page
