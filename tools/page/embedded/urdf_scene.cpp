// Links in the order of the tree. A mesh is looked for under the package's name beside the URDF,
// and by its path from there: model folders are moved about, and ROS is not needed to read one.
#include "tools/page/embedded/urdf_scene.h"

#include <fmt/format.h>

#include <cctype>
#include <nlohmann/json.hpp>

#include "host/model/urdf_text.h"
#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "tools/page/embedded/packing.h"

namespace sanso::page {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json list(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

void put_pose(json& out, const urdf::Pose& pose) {
  out["pos"] = list(pose.position);
  out["quat"] = {pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z};
}

class Drawing {
 public:
  Drawing(const urdf::ModelInterface& robot, std::string file, fs::path folder, std::size_t most)
      : file_(std::move(file)), folder_(std::move(folder)), left_(most) {
    out_ = {{"links", json::array()}, {"notes", json::array()}};
    add_link(*robot.getRoot(), -1, nullptr);
  }
  json take() { return std::move(out_); }

 private:
  void add_link(const urdf::Link& link, int parent, const urdf::Joint* joint) {
    const auto place = static_cast<int>(out_["links"].size());
    json l = {{"name", link.name}, {"parent", parent}, {"shapes", json::array()}};
    put_pose(l, joint ? joint->parent_to_joint_origin_transform : urdf::Pose());
    if (joint && joint->type != urdf::Joint::FIXED)
      l["joint"] = {{"name", joint->name},
                    {"axis", list(joint->axis)},
                    {"slides", joint->type == urdf::Joint::PRISMATIC}};
    if (link.inertial && link.inertial->mass > 0.0) l["com"] = list(link.inertial->origin.position);
    for (const auto& visual : link.visual_array)
      if (visual && visual->geometry)
        add_shape(l["shapes"], link, *visual->geometry, visual->origin);
    if (l["shapes"].empty())
      for (const auto& collision : link.collision_array)
        if (collision && collision->geometry)
          add_shape(l["shapes"], link, *collision->geometry, collision->origin);
    out_["links"].push_back(std::move(l));
    for (const auto& child : link.child_joints)
      add_link(model::child_of(link, *child, file_), place, child.get());
  }

  void add_shape(json& shapes, const urdf::Link& link, const urdf::Geometry& geometry,
                 const urdf::Pose& pose) {
    json shape;
    if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      shape = {{"type", "box"}, {"size", list(box->dim)}};
    } else if (const auto* ball = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      shape = {{"type", "sphere"}, {"radius", ball->radius}};
    } else if (const auto* rod = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      shape = {{"type", "cylinder"}, {"radius", rod->radius}, {"length", rod->length}};
    } else if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
      const std::string stl = stl_of(*mesh, link.name);
      if (stl.empty()) return;
      shape = {{"type", "mesh"}, {"scale", list(mesh->scale)}, {"stl", base64(stl)}};
    }
    if (shape.is_null()) return;
    put_pose(shape, pose);
    shapes.push_back(std::move(shape));
  }

  /// The bytes of a mesh; empty, with a note, when it cannot be drawn.
  std::string stl_of(const urdf::Mesh& mesh, const std::string& link) {
    const auto note = [&](const std::string& why) {
      out_["notes"].push_back(fmt::format("{}: mesh {} {}", link, mesh.filename, why));
      return std::string();
    };
    std::string name = mesh.filename;
    for (const char* scheme : {"package://", "file://"})
      if (name.starts_with(scheme)) name.erase(0, std::string(scheme).size());
    std::string extension = fs::path(name).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (extension != ".stl") return note("is no STL");
    const std::size_t slash = name.find('/');
    const std::string in_package = slash == std::string::npos ? name : name.substr(slash + 1);
    for (const fs::path& path : {folder_ / name, folder_ / in_package}) {
      std::error_code error;
      const std::uintmax_t size = fs::file_size(path, error);
      if (error) continue;
      if (size > left_) return note("would make the page too large");
      left_ -= size;
      try {
        return files::read_text(path);
      } catch (const files::InputError&) {
        return note("cannot be read");
      }
    }
    return note("is not beside the URDF");
  }

  std::string file_;
  fs::path folder_;
  std::size_t left_;
  json out_;
};

}  // namespace

json scene_of_urdf(const std::string& urdf, const std::string& file, const fs::path& folder,
                   std::size_t most_mesh_bytes) {
  return Drawing(*model::parse_urdf_text(urdf, file), file, folder, most_mesh_bytes).take();
}

}  // namespace sanso::page
