// Reads the maker's tables by column name; a missing column or file is an error at start.
#include "tools/plant/body_data.h"

#include <map>
#include <sstream>

#include "tools/plant/world_error.h"

namespace sanso::plant {
namespace {

using Row = std::map<std::string, std::string>;

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

std::vector<Row> read_csv(const std::string& name) {
  std::istringstream in(built_in_file(name));
  std::string line;
  if (!std::getline(in, line)) throw WorldError("built-in table " + name + " is empty");
  const auto header = split(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    const auto cells = split(line);
    Row row;
    for (std::size_t i = 0; i < cells.size(); ++i) row[header.at(i)] = cells[i];
    rows.push_back(row);
  }
  return rows;
}

double number(const Row& row, const std::string& column) { return std::stod(row.at(column)); }

Vec3 vector3(const Row& row, const std::string& x, const std::string& y, const std::string& z) {
  return {number(row, x), number(row, y), number(row, z)};
}

BodyData read_body() {
  BodyData body;
  for (const Row& row : read_csv("op3_links.csv")) {
    if (number(row, "mass_kg") == 0.0) continue;  // camera frames
    body.links.push_back({row.at("name"), row.at("parent"), number(row, "mass_kg"),
                          vector3(row, "com_x_m", "com_y_m", "com_z_m"), number(row, "ixx_kgm2"),
                          number(row, "ixy_kgm2"), number(row, "ixz_kgm2"), number(row, "iyy_kgm2"),
                          number(row, "iyz_kgm2"), number(row, "izz_kgm2")});
  }
  for (const Row& row : read_csv("op3_joints.csv")) {
    if (row.at("type") != "revolute") continue;
    body.joints.push_back({row.at("name"), row.at("parent_link"), row.at("child_link"),
                           vector3(row, "origin_x_m", "origin_y_m", "origin_z_m"),
                           vector3(row, "axis_x", "axis_y", "axis_z"),
                           static_cast<int>(number(row, "dynamixel_id"))});
  }
  return body;
}

}  // namespace

const BodyData& op3_body() {
  static const BodyData body = read_body();
  return body;
}

}  // namespace sanso::plant
