// Shapes are taken from the text of the MJCF, so that they are said once: boxes and capsules are
// URDF's boxes and cylinders, the points of a sole become the box around them.
#include "tools/export/op3_urdf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <vector>

#include "tools/plant/body_data.h"
#include "tools/plant/mjcf.h"

namespace sanso::exports {
namespace {

using plant::Vec3;

/// The value of an attribute in the text of one element; empty when it has none.
std::string attribute(std::string_view element, const std::string& name) {
  const std::string mark = " " + name + "=\"";
  const std::size_t at = element.find(mark);
  if (at == std::string_view::npos) return {};
  const std::size_t begin = at + mark.size();
  return std::string(element.substr(begin, element.find('"', begin) - begin));
}

std::vector<double> numbers(const std::string& text) {
  std::istringstream in(text);
  std::vector<double> out;
  for (double v = 0; in >> v;) out.push_back(v);
  return out;
}

std::string xyz(double x, double y, double z) {
  return fmt::format("{:.9g} {:.9g} {:.9g}", x, y, z);
}
std::string xyz(const Vec3& v) { return xyz(v[0], v[1], v[2]); }

std::string visual(const std::string& origin, const std::string& rpy, const std::string& shape) {
  return fmt::format(
      "    <visual><origin xyz=\"{}\" rpy=\"{}\"/><geometry>{}</geometry></visual>\n", origin, rpy,
      shape);
}

/// A capsule from one end to the other as a cylinder along its own z.
std::string cylinder(const std::vector<double>& ends, double radius) {
  const double dx = ends[3] - ends[0], dy = ends[4] - ends[1], dz = ends[5] - ends[2];
  const double length = std::hypot(dx, dy, dz);
  const double pitch = std::atan2(std::hypot(dx, dy), dz), yaw = std::atan2(dy, dx);
  return visual(
      xyz(0.5 * (ends[0] + ends[3]), 0.5 * (ends[1] + ends[4]), 0.5 * (ends[2] + ends[5])),
      xyz(0.0, pitch, yaw),
      fmt::format("<cylinder radius=\"{:.9g}\" length=\"{:.9g}\"/>", radius, length));
}

/// The box around the points of a sole.
struct Sole {
  std::array<double, 3> low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
  bool any = false;
  void add(const std::vector<double>& at, double radius) {
    any = true;
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], at[k] - radius);
      high[k] = std::max(high[k], at[k] + radius);
    }
  }
  std::string box() const {
    return visual(xyz(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2])),
                  "0 0 0",
                  fmt::format("<box size=\"{}\"/>",
                              xyz(high[0] - low[0], high[1] - low[1], high[2] - low[2])));
  }
};

/// Shapes by link. A geom belongs to the body that was opened last and is not closed.
std::map<std::string, std::string> shapes() {
  const std::string mjcf = plant::make_mjcf(plant::load_world("nominal"));
  std::map<std::string, std::string> out;
  std::map<std::string, Sole> soles;
  std::vector<std::string> open;
  for (std::size_t at = mjcf.find('<'); at != std::string::npos; at = mjcf.find('<', at + 1)) {
    const std::string_view element = std::string_view(mjcf).substr(at, mjcf.find('>', at) - at);
    if (element.starts_with("<body ")) open.push_back(attribute(element, "name"));
    if (element.starts_with("</body")) open.pop_back();
    if (!element.starts_with("<geom ") || open.empty()) continue;
    const std::vector<double> size = numbers(attribute(element, "size"));
    const std::vector<double> pos = numbers(attribute(element, "pos"));
    const std::string type = attribute(element, "type");
    if (attribute(element, "class") == "sole" && type == "sphere")
      soles[open.back()].add(pos, size.at(0));
    else if (type == "box")
      out[open.back()] += visual(
          xyz(pos.at(0), pos.at(1), pos.at(2)), "0 0 0",
          fmt::format("<box size=\"{}\"/>", xyz(2 * size.at(0), 2 * size.at(1), 2 * size.at(2))));
    else if (type == "capsule")
      out[open.back()] += cylinder(numbers(attribute(element, "fromto")), size.at(0));
  }
  for (const auto& [link, sole] : soles) out[link] += sole.box();
  return out;
}

/// The joint's range in the MJCF.
std::string limit_of(const std::string& mjcf, const std::string& joint) {
  const std::size_t at = mjcf.find("<joint name=\"" + joint + "\"");
  const std::vector<double> range =
      numbers(attribute(std::string_view(mjcf).substr(at, mjcf.find('>', at) - at), "range"));
  // effort and velocity are asked for by the format; nobody reads them here
  return fmt::format(R"(<limit lower="{:.9g}" upper="{:.9g}" effort="4.1" velocity="4.8"/>)",
                     range.at(0), range.at(1));
}

}  // namespace

std::string op3_urdf() {
  const std::map<std::string, std::string> drawn = shapes();
  const std::string mjcf = plant::make_mjcf(plant::load_world("nominal"));
  std::string out =
      "<?xml version=\"1.0\"?>\n<robot name=\"op3\">\n  <link name=\"base_link\"/>\n"
      "  <joint name=\"base_joint\" type=\"fixed\"><parent link=\"base_link\"/>"
      "<child link=\"body_link\"/></joint>\n";
  for (const plant::LinkData& l : plant::op3_body().links) {
    const auto shape = drawn.find(l.name);
    out += fmt::format(
        "  <link name=\"{}\">\n    <inertial><origin xyz=\"{}\"/><mass value=\"{:.9g}\"/>"
        "<inertia ixx=\"{:.9g}\" ixy=\"{:.9g}\" ixz=\"{:.9g}\" iyy=\"{:.9g}\" iyz=\"{:.9g}\" "
        "izz=\"{:.9g}\"/></inertial>\n{}  </link>\n",
        l.name, xyz(l.com_m), l.mass_kg, l.ixx, l.ixy, l.ixz, l.iyy, l.iyz, l.izz,
        shape == drawn.end() ? "" : shape->second);
  }
  for (const plant::JointData& j : plant::op3_body().joints)
    out += fmt::format(
        "  <joint name=\"{}\" type=\"revolute\"><parent link=\"{}\"/><child link=\"{}\"/>"
        "<origin xyz=\"{}\"/><axis xyz=\"{}\"/>{}</joint>\n",
        j.name, j.parent, j.child, xyz(j.origin_m), xyz(j.axis), limit_of(mjcf, j.name));
  return out + "</robot>\n";
}

}  // namespace sanso::exports
