// The same file is read twice: for the settings of every robot, and for those of one that floats.
#include "tools/diagnose/model_folder/whole_body.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/files/toml.h"
#include "tools/diagnose/model_folder/model_text.h"

namespace sanso::diagnose {
namespace {

using files::InputError;
using files::TomlTable;

// chosen: a kitten on foam to a machine bolted to rock
constexpr double kSoftest = 1.0, kHardest = 1e9;

Vec3 vector_of(const TomlTable& table, const std::string& key, const Vec3& otherwise) {
  const auto v = table.numbers(key, 3);
  return v ? Vec3{(*v)[0], (*v)[1], (*v)[2]} : otherwise;
}

ContactMaterial read_material(const TomlTable& table) {
  return {table.number("friction", 0.0, 10.0), table.number("stiffness", kSoftest, kHardest),
          table.number("damping", 0.0, kHardest)};
}

const LinkPlace& place_of(const TomlTable& table, const std::string& link, const WholeBody& body) {
  const auto place = body.model.tree.links.find(link);
  if (place == body.model.tree.links.end())
    table.fail("link", "unknown link", link, "a link of the URDF");
  return place->second;
}

void read_imu(const TomlTable& table, WholeBody& body) {
  table.allow_only({"link", "xyz", "rpy"});
  ImuPlace& imu = body.imu;
  imu.given = true;
  imu.link = table.string("link").value_or(body.root);
  imu.xyz = vector_of(table, "xyz", imu.xyz);
  imu.rpy = vector_of(table, "rpy", imu.rpy);
  const LinkPlace& link = place_of(table, imu.link, body);
  imu.joint = link.joint;
  imu.R_joint_imu = product(link.R_joint_link, rotation_of_rpy(imu.rpy));
  imu.p_joint_imu = link.p_joint_link + rotated(link.R_joint_link, imu.xyz);
}

/// A shape that model.toml gives a link takes the place of the URDF's.
void put_shape(const ContactSetting& contact, const LinkPlace& link, WholeBody& body) {
  if (!contact.box && !contact.sphere) return;
  std::erase_if(body.shapes, [&](const CollisionShape& s) { return s.link == contact.link; });
  CollisionShape shape{contact.link, link.joint, {{0, 0, 0}}, contact.sphere.value_or(0.0)};
  if (contact.box) shape.points = box_corners(*contact.box);
  const Mat3 R = product(link.R_joint_link, rotation_of_rpy(contact.rpy));
  const Vec3 p = link.p_joint_link + rotated(link.R_joint_link, contact.xyz);
  for (Vec3& point : shape.points) point = p + rotated(R, point);
  body.shapes.push_back(std::move(shape));
}

void read_contact(const TomlTable& table, WholeBody& body) {
  table.allow_only({"link", "friction", "stiffness", "damping", "box", "sphere", "xyz", "rpy"});
  ContactSetting contact;
  contact.link = table.need("link", table.string("link"), "a link of the URDF");
  contact.material = read_material(table);
  if (table.has("box")) contact.box = vector_of(table, "box", {});
  contact.sphere = table.number("sphere", 0.0, 10.0);
  if (contact.box && contact.sphere)
    table.fail("sphere", "two shapes for one contact", "", "box = [x, y, z] or sphere = radius");
  contact.xyz = vector_of(table, "xyz", contact.xyz);
  contact.rpy = vector_of(table, "rpy", contact.rpy);
  put_shape(contact, place_of(table, contact.link, body), body);
  body.contacts.push_back(std::move(contact));
}

/// The number inside <tag>...</tag> or of its value="..." between two places of a text.
std::optional<double> tag_number(std::string_view text, const std::string& tag) {
  const std::size_t open = text.find("<" + tag);
  if (open == std::string_view::npos) return std::nullopt;
  std::size_t begin = text.find_first_of(">\"", open + tag.size() + 1);
  if (begin == std::string_view::npos) return std::nullopt;
  begin = text.find_first_not_of(" \t\r\n", begin + 1);
  if (begin == std::string_view::npos) return std::nullopt;
  double value = 0.0;
  const auto end = std::from_chars(text.data() + begin, text.data() + text.size(), value);
  if (end.ec != std::errc{} || !std::isfinite(value) || value < 0.0) return std::nullopt;
  return value;
}

/// <gazebo reference="foot"> <mu1> <kp> <kd>: what simulators read beside the URDF.
std::vector<ContactSetting> gazebo_materials(std::string_view urdf) {
  std::vector<ContactSetting> out;
  constexpr std::string_view kOpen = "<gazebo", kClose = "</gazebo>", kReference = "reference=\"";
  for (std::size_t at = urdf.find(kOpen); at != std::string_view::npos;) {
    const std::size_t close = std::min(urdf.find(kClose, at), urdf.size());
    const std::string_view tag = urdf.substr(at, close - at);
    const std::size_t named = tag.find(kReference);
    if (named != std::string_view::npos) {
      const std::string_view rest = tag.substr(named + kReference.size());
      ContactSetting c;
      c.link = std::string(rest.substr(0, rest.find('"')));
      c.material = {tag_number(tag, "mu1"), tag_number(tag, "kp"), tag_number(tag, "kd")};
      const ContactMaterial& m = c.material;
      if (m.friction || m.stiffness || m.damping) out.push_back(std::move(c));
    }
    at = urdf.find(kOpen, at + kOpen.size());
  }
  return out;
}

void fill(ContactMaterial& material, const ContactMaterial& from) {
  if (!material.friction) material.friction = from.friction;
  if (!material.stiffness) material.stiffness = from.stiffness;
  if (!material.damping) material.damping = from.damping;
}

/// Links whose shape is a mesh and that no [[contact]] gives another: at most three by name.
void note_meshes(const std::vector<std::string>& meshes, WholeBody& body) {
  std::string names;
  std::size_t count = 0;
  for (const std::string& link : meshes) {
    const bool known = std::any_of(body.shapes.begin(), body.shapes.end(),
                                   [&](const CollisionShape& s) { return s.link == link; });
    if (!known && ++count <= 3) names += (names.empty() ? "" : ", ") + link;
  }
  if (count == 0) return;
  body.notes.push_back("meshes are not read: " + std::to_string(count) + " links (" + names +
                       (count > 3 ? ", ...)" : ")") +
                       " have no shape; [[contact]] with box or sphere says what touches");
}

WholeBody complete(ModelFolder model, const TomlTable& top, const std::string& urdf_name,
                   const WholeSettings& settings) {
  WholeBody body;
  BodyTree tree = body_tree_from_urdf(model.urdf, urdf_name, settings.rim_points);
  body.model = std::move(model);
  body.root = tree.root;
  body.base = tree.base;
  body.shapes = std::move(tree.shapes);
  body.imu.link = body.root;
  if (const auto table = top.table("imu")) read_imu(*table, body);
  if (const auto table = top.table("ground")) {
    body.ground.material = read_material(*table);
    body.ground.height = table->number("height", -1000.0, 1000.0);
    body.ground.restitution = table->number("restitution", 0.0, 1.0);
  }
  for (const TomlTable& table : top.tables("contact")) read_contact(table, body);
  note_meshes(tree.meshes, body);
  if (!(body.mass() > 0.0)) {
    throw InputError(urdf_name, 0, body.root, "robot without mass", "0",
                     "an <inertial> of at least one link");
  }
  return body;
}

std::string list(const Vec3& v) {
  return "[" + files::toml_number(v[0]) + ", " + files::toml_number(v[1]) + ", " +
         files::toml_number(v[2]) + "]";
}

void append_material(std::ostringstream& out, const ContactMaterial& m) {
  if (m.friction) out << "friction = " << files::toml_number(*m.friction) << "\n";
  if (m.stiffness) out << "stiffness = " << files::toml_number(*m.stiffness) << "  # N/m\n";
  if (m.damping) out << "damping = " << files::toml_number(*m.damping) << "  # N s/m\n";
}

std::string ground_lines(const WholeBody& body) {
  std::ostringstream out;
  const Ground& g = body.ground;
  out << "\n[ground]\nkind = " << files::toml_quoted(to_string(body.model.ground_kind)) << "\n";
  append_material(out, g.material);
  if (g.restitution) out << "restitution = " << files::toml_number(*g.restitution) << "\n";
  if (g.height) out << "height = " << files::toml_number(*g.height) << "  # m\n";
  return out.str();
}

}  // namespace

Mat3 rotation_of_rpy(const Vec3& rpy) {
  const double cr = std::cos(rpy[0]), sr = std::sin(rpy[0]), cp = std::cos(rpy[1]),
               sp = std::sin(rpy[1]), cy = std::cos(rpy[2]), sy = std::sin(rpy[2]);
  return {cy * cp,
          cy * sp * sr - sy * cr,
          cy * sp * cr + sy * sr,
          sy * cp,
          sy * sp * sr + cy * cr,
          sy * sp * cr - cy * sr,
          -sp,
          cp * sr,
          cp * cr};
}

ContactMaterial WholeBody::material_of(const std::string& link) const {
  ContactMaterial out;
  for (const ContactSetting& c : contacts) {
    if (c.link == link) fill(out, c.material);
  }
  for (const ContactSetting& c : gazebo_materials(model.urdf)) {
    if (c.link == link) fill(out, c.material);
  }
  fill(out, ground.material);
  return out;
}

double WholeBody::mass() const {
  double sum = base.mass;
  for (const TreeJoint& joint : model.tree.joints) sum += joint.body.mass;
  return sum;
}

WholeBody parse_whole_body(std::string_view toml, std::string_view urdf, const std::string& name,
                           const WholeSettings& settings) {
  ModelFolder model = parse_model(toml, urdf, name);
  const std::string urdf_name = model.urdf_file;
  return complete(std::move(model), TomlTable::parse(toml, name), urdf_name, settings);
}

WholeBody read_whole_body(const std::string& folder, const WholeSettings& settings) {
  ModelFolder model = read_model_folder(folder);
  const std::filesystem::path path = folder;
  const std::string urdf_name = (path / model.urdf_file).string();
  return complete(std::move(model), TomlTable::read((path / "model.toml").string()), urdf_name,
                  settings);
}

std::string whole_body_toml(const WholeBody& body) {
  std::ostringstream out;
  out << robot_text(body.model) << ground_lines(body);
  if (body.imu.given) {
    out << "\n[imu]\nlink = " << files::toml_quoted(body.imu.link)
        << "\nxyz = " << list(body.imu.xyz) << "  # m\nrpy = " << list(body.imu.rpy) << "  # rad\n";
  }
  for (const ContactSetting& c : body.contacts) {
    out << "\n[[contact]]\nlink = " << files::toml_quoted(c.link) << "\n";
    append_material(out, c.material);
    if (c.box) out << "box = " << list(*c.box) << "  # m\n";
    if (c.sphere) out << "sphere = " << files::toml_number(*c.sphere) << "  # m\n";
    out << "xyz = " << list(c.xyz) << "\nrpy = " << list(c.rpy) << "\n";
  }
  out << effects_text(body.model);
  return out.str();
}

void write_whole_body(const WholeBody& body, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  files::write_atomically(std::filesystem::path(folder) / body.model.urdf_file, body.model.urdf);
  files::write_atomically(std::filesystem::path(folder) / "model.toml", whole_body_toml(body));
}

}  // namespace sanso::diagnose
