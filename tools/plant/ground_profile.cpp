// Walks along the corners: a heading, a position, straight ahead and round the bends in chords of
// at most a centimetre.
#include "tools/plant/ground_profile.h"

#include <algorithm>
#include <cmath>

#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "tools/plant/body_data.h"
#include "tools/plant/vec.h"
#include "tools/plant/world_error.h"

namespace sanso::plant {
namespace {

using files::TomlTable;

// a chord of it stays within 16 um of an arc of 0.8 m, and bends by 0.7 degrees
constexpr double kChord_m = 0.01;
constexpr double kBeyond_m = 3.0;  // how far first and last line go on
constexpr double kLevel_m = 1e-4;  // at the start: figures in files are rounded

struct Point {
  double x, z;
  double radius;
  TomlTable from;  // for messages
};

struct Patch {
  double from_x, to_x, factor;
};

Point read_point(const TomlTable& table) {
  Point point{table.need("x_m", table.number("x_m", -100, 100), "metres"),
              table.need("z_m", table.number("z_m", -10, 10), "metres"), 0.0, table};
  TomlTable::into(point.radius, table.number("radius_m", 0.05, 100));
  table.finish("x_m, z_m or radius_m");
  return point;
}

Patch read_patch(const TomlTable& table) {
  Patch patch{};
  patch.from_x = table.need("from_x_m", table.number("from_x_m", -100, 100), "metres");
  patch.to_x = table.need("to_x_m", table.number("to_x_m", patch.from_x, 100), "metres");
  patch.factor =
      table.need("friction_factor", table.number("friction_factor", 0.05, 5), "a factor");
  table.finish("from_x_m, to_x_m or friction_factor");
  return patch;
}

double heading(const Point& a, const Point& b) { return std::atan2(b.z - a.z, b.x - a.x); }

/// Unit of way from the corner to where its arc begins, over the radius.
double setback(const std::vector<Point>& points, std::size_t i) {
  if (i == 0 || i + 1 == points.size() || points[i].radius == 0.0) return 0.0;
  const double turn = heading(points[i], points[i + 1]) - heading(points[i - 1], points[i]);
  return points[i].radius * std::tan(std::abs(turn) / 2.0);
}

class Walk {
 public:
  explicit Walk(std::vector<Facet>& facets) : facets_(facets) {}
  void stand_at(double x, double z) { x_ = x, z_ = z; }
  void ahead(double length, double angle) {
    const double x = x_ + length * std::cos(angle), z = z_ + length * std::sin(angle);
    if (length > 1e-9) facets_.push_back({x_, z_, x, z});
    stand_at(x, z);
  }
  void bend(double radius, double from, double to) {
    const double turn = to - from;
    const int chords = std::max(1, static_cast<int>(std::ceil(radius * std::abs(turn) / kChord_m)));
    const double each = turn / chords, length = 2.0 * radius * std::sin(std::abs(each) / 2.0);
    for (int i = 0; i < chords; ++i) ahead(length, from + (i + 0.5) * each);
  }

 private:
  std::vector<Facet>& facets_;
  double x_ = 0, z_ = 0;
};

void check_line(const std::vector<Point>& points, std::size_t i) {
  const Point &a = points[i], &b = points[i + 1];
  const double length = std::hypot(b.x - a.x, b.z - a.z);
  if (b.x < a.x)
    b.from.fail("x_m", "points out of order", files::toml_number(b.x),
                "x at least that of the point before");
  if (b.x == a.x) {
    if (a.radius > 0 || b.radius > 0 || i == 0 || i + 2 == points.size())
      b.from.fail("radius_m", "arc or end at a step", "",
                  "lines before and behind a vertical step");
    return;
  }
  if (std::abs(b.z - a.z) > b.x - a.x)
    b.from.fail("z_m", "too steep", files::toml_number(b.z),
                "at most 45 degrees, or a vertical step");
  if (setback(points, i) + setback(points, i + 1) > length)
    b.from.fail("radius_m", "arc does not fit", "", "a smaller radius or longer lines");
}

std::vector<Facet> facets_of(const std::vector<Point>& points) {
  std::vector<Facet> facets;
  Walk walk(facets);
  const double first = heading(points[0], points[1]);
  walk.stand_at(points[0].x - kBeyond_m * std::cos(first),
                points[0].z - kBeyond_m * std::sin(first));
  walk.ahead(kBeyond_m, first);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    check_line(points, i);
    if (points[i + 1].x == points[i].x) {
      walk.stand_at(points[i + 1].x, points[i + 1].z);
      continue;
    }
    const double angle = heading(points[i], points[i + 1]);
    const double length = std::hypot(points[i + 1].x - points[i].x, points[i + 1].z - points[i].z);
    walk.ahead(length - setback(points, i) - setback(points, i + 1), angle);
    if (setback(points, i + 1) > 0)
      walk.bend(points[i + 1].radius, angle, heading(points[i + 1], points[i + 2]));
  }
  walk.ahead(kBeyond_m, heading(points[points.size() - 2], points.back()));
  return facets;
}

/// Cuts facets where a patch begins or ends, and gives the pieces inside its friction.
void lay_patch(const Patch& patch, std::vector<Facet>& facets) {
  for (const double at : {patch.from_x, patch.to_x}) {
    for (std::size_t i = 0; i < facets.size(); ++i) {
      Facet& f = facets[i];
      if (at <= f.x0 || at >= f.x1) continue;
      Facet rest = f;
      rest.x0 = f.x1 = at;
      rest.z0 = f.z1 = f.z0 + (at - f.x0) * (rest.z1 - f.z0) / (rest.x1 - facets[i].x0);
      facets.insert(facets.begin() + static_cast<std::ptrdiff_t>(i) + 1, rest);
      break;
    }
  }
  for (Facet& f : facets) {
    const double middle = 0.5 * (f.x0 + f.x1);
    if (middle > patch.from_x && middle < patch.to_x) f.friction_factor = patch.factor;
  }
}

GroundProfile read_profile(const TomlTable& top) {
  top.need("format", top.integer("format", 1, 1), "1");
  top.string("about");
  GroundProfile profile;
  TomlTable::into(profile.width_m, top.number("width_m", 0.2, 10));
  std::vector<Point> points;
  for (const TomlTable& point : top.tables("point")) points.push_back(read_point(point));
  if (points.size() < 2) top.fail("point", "too few points", "", "at least two [[point]]");
  profile.facets = facets_of(points);
  for (const Facet& f : profile.facets) {
    const double start = f.z0 - f.x0 * (f.z1 - f.z0) / (f.x1 - f.x0);
    if (f.x0 <= 0.0 && f.x1 > 0.0 && std::abs(start) > kLevel_m)
      top.fail("point", "start is not level with zero", files::toml_number(start),
               "height 0 at x = 0, where the robot stands");
  }
  for (const TomlTable& patch : top.tables("patch")) lay_patch(read_patch(patch), profile.facets);
  top.finish("format, about, width_m, [[point]] or [[patch]]");
  return profile;
}

}  // namespace

bool has_profile(const std::string& name) { return !built_in_file("grounds/" + name).empty(); }

GroundProfile parse_profile(const std::string& toml_text, const std::string& origin) {
  try {
    return read_profile(TomlTable::parse(toml_text, origin));
  } catch (const files::InputError& error) {
    throw WorldError(error.what());
  }
}

GroundProfile load_profile(const std::string& name_or_path) {
  if (has_profile(name_or_path))
    return parse_profile(built_in_file("grounds/" + name_or_path),
                         "shared/grounds/" + name_or_path + ".toml");
  try {
    return read_profile(TomlTable::read(name_or_path));
  } catch (const files::InputError& error) {
    throw WorldError(std::string(error.what()) +
                     "; a ground is plane, slope3, ramp, ramp_high, jump_ramp, plates, stairs or a "
                     "profile file");
  }
}

}  // namespace sanso::plant
