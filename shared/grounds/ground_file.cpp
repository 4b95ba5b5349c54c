// Reads the corners of a profile and has the model's ground made of them; what does not fit is an
// error at the corner's line.
#include "shared/grounds/ground_file.h"

#include <cmath>
#include <vector>

#include "shared/files/input_error.h"
#include "shared/files/toml.h"

namespace sanso::grounds {
namespace {

using files::TomlTable;

model::GroundCorner read_corner(const TomlTable& table) {
  model::GroundCorner corner{};
  corner.x = table.need("x_m", table.number("x_m", -100, 100), "metres");
  corner.z = table.need("z_m", table.number("z_m", -10, 10), "metres");
  TomlTable::into(corner.radius, table.number("radius_m", 0.05, 100));
  table.finish("x_m, z_m or radius_m");
  return corner;
}

/// The planner has one friction for the whole ground: patches are read, and left to identification.
void check_patch(const TomlTable& table) {
  const double from = table.need("from_x_m", table.number("from_x_m", -100, 100), "metres");
  table.need("to_x_m", table.number("to_x_m", from, 100), "metres, at least from_x_m");
  table.need("friction_factor", table.number("friction_factor", 0.05, 5), "a factor");
  table.finish("from_x_m, to_x_m or friction_factor");
}

[[noreturn]] void refuse(const TomlTable& top, const model::GroundDefect& defect) {
  const std::vector<TomlTable> points = top.tables("point");
  const auto at = static_cast<std::size_t>(defect.corner);
  const TomlTable& where = at < points.size() ? points[at] : top;
  where.fail(defect.key, defect.what, "", defect.expected);
}

model::Ground read_ground(const TomlTable& top) {
  top.need("format", top.integer("format", 1, 1), "1");
  top.string("about");
  top.number("width_m", 0.2, 10);
  std::vector<model::GroundCorner> corners;
  for (const TomlTable& point : top.tables("point")) corners.push_back(read_corner(point));
  for (const TomlTable& patch : top.tables("patch")) check_patch(patch);
  top.finish("format, about, width_m, [[point]] or [[patch]]");
  model::Ground ground;
  const model::GroundDefect defect =
      model::make_profile(corners.data(), static_cast<int>(corners.size()), ground);
  if (defect.what) refuse(top, defect);
  return ground;
}

}  // namespace

model::Ground parse_ground(const std::string& toml_text, const std::string& origin) {
  return read_ground(TomlTable::parse(toml_text, origin));
}

model::Ground load_ground(const std::string& name_or_path) {
  if (name_or_path == "plane") return model::make_plane();
  const auto built_in = built_in_grounds().find(name_or_path);
  if (built_in != built_in_grounds().end())
    return parse_ground(built_in->second, "shared/grounds/" + name_or_path + ".toml");
  if (name_or_path.find('.') == std::string::npos) {
    std::string known = "plane";
    for (const auto& [name, text] : built_in_grounds()) known += ", " + name;
    throw files::InputError(name_or_path, 0, "", "no such ground", "",
                            known + " or the path of a file");
  }
  return read_ground(TomlTable::read(name_or_path));
}

}  // namespace sanso::grounds
