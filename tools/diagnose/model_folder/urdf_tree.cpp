// URDF text to RobotTree or BodyTree. The XML is read by urdfdom; what the simulator cannot do is
// refused by name.
#include <cmath>
#include <numbers>

#include "host/model/urdf_text.h"
#include "shared/files/input_error.h"
#include "tools/diagnose/model_folder/body_tree.h"

namespace sanso::diagnose {
namespace {

using files::InputError;

Mat3 rotation(const urdf::Rotation& q) {
  const double w = q.w, x = q.x, y = q.y, z = q.z;
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}
Vec3 vector(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

class TreeBuilder {
 public:
  TreeBuilder(const urdf::ModelInterface& model, std::string file, std::size_t most_joints,
              int rim_points)
      : file_(std::move(file)), most_joints_(most_joints), rim_points_(rim_points) {
    body_.tree.name = model.getName();
    body_.root = model.getRoot()->name;
    add_link(*model.getRoot(), -1, kIdentity3, {0, 0, 0});
  }
  BodyTree take() { return std::move(body_); }

 private:
  [[noreturn]] void fail(const std::string& where, const char* defect, const std::string& value,
                         const char* expected) const {
    throw InputError(file_, 0, where, defect, value, expected);
  }

  /// Adds a link that sits at (R, p) in the frame of joint `joint`, then everything behind it.
  void add_link(const urdf::Link& link, int joint, const Mat3& R, const Vec3& p) {
    RobotTree& tree = body_.tree;
    tree.links[link.name] = {joint, R, p};
    if (link.inertial) {
      add_body(joint < 0 ? body_.base : tree.joints[static_cast<std::size_t>(joint)].body,
               moved(inertia(link), R, p));
    }
    for (const auto& collision : link.collision_array) add_shape(link, *collision, joint, R, p);
    for (const auto& child : link.child_joints) add_joint(*child, link, joint, R, p);
  }

  void add_joint(const urdf::Joint& joint, const urdf::Link& link, int parent, const Mat3& R,
                 const Vec3& p) {
    const auto& origin = joint.parent_to_joint_origin_transform;
    const Mat3 R_parent_joint = product(R, rotation(origin.rotation));
    const Vec3 p_parent_joint = p + rotated(R, vector(origin.position));
    const urdf::Link& child = model::child_of(link, joint, file_);
    if (joint.type == urdf::Joint::FIXED) {
      add_link(child, parent, R_parent_joint, p_parent_joint);
      return;
    }
    const bool prismatic = joint.type == urdf::Joint::PRISMATIC;
    if (!prismatic && joint.type != urdf::Joint::REVOLUTE &&
        joint.type != urdf::Joint::CONTINUOUS) {
      fail(joint.name, "joint type not supported", "", "revolute, continuous, prismatic or fixed");
    }
    if (body_.tree.size() >= most_joints_) {
      throw InputError(file_, 0, joint.name, "too many joints", "",
                       "at most " + std::to_string(most_joints_) + " movable joints");
    }
    TreeJoint t;
    t.name = joint.name;
    t.link = child.name;
    t.prismatic = prismatic;
    t.parent = parent;
    t.R_parent_joint = R_parent_joint;
    t.p_parent_joint = p_parent_joint;
    t.axis = unit_axis(joint);
    if (joint.limits) {
      if (joint.type != urdf::Joint::CONTINUOUS)
        t.lower = joint.limits->lower, t.upper = joint.limits->upper;
      t.effort = joint.limits->effort;
      t.speed = joint.limits->velocity;
    }
    body_.tree.joints.push_back(t);
    add_link(child, static_cast<int>(body_.tree.size()) - 1, kIdentity3, {0, 0, 0});
  }

  /// Boxes, spheres and cylinders; meshes are named, so that somebody can say what touches.
  void add_shape(const urdf::Link& link, const urdf::Collision& collision, int joint, const Mat3& R,
                 const Vec3& p) {
    if (!collision.geometry) return;
    CollisionShape shape{link.name, joint, {}, 0.0};
    if (const auto* box = dynamic_cast<const urdf::Box*>(collision.geometry.get())) {
      shape.points = box_corners(vector(box->dim));
    } else if (const auto* ball = dynamic_cast<const urdf::Sphere*>(collision.geometry.get())) {
      shape.points = {{0, 0, 0}};
      shape.radius = ball->radius;
    } else if (const auto* can = dynamic_cast<const urdf::Cylinder*>(collision.geometry.get())) {
      shape.points = cylinder_rims(can->radius, can->length, rim_points_);
    } else {
      body_.meshes.push_back(link.name);
      return;
    }
    const Mat3 R_shape = product(R, rotation(collision.origin.rotation));
    const Vec3 p_shape = p + rotated(R, vector(collision.origin.position));
    for (Vec3& point : shape.points) point = p_shape + rotated(R_shape, point);
    body_.shapes.push_back(std::move(shape));
  }

  Vec3 unit_axis(const urdf::Joint& joint) const {
    Vec3 a = vector(joint.axis);
    const double n = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (!(n > 1e-9) || !std::isfinite(n))
      fail(joint.name, "axis of no length", "", "a unit vector");
    for (double& c : a) c /= n;
    return a;
  }

  BodyInertia inertia(const urdf::Link& link) const {
    const urdf::Inertial& in = *link.inertial;
    const Mat3 I{in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz};
    bool good =
        std::isfinite(in.mass) && in.mass >= 0.0 && in.ixx >= 0.0 && in.iyy >= 0.0 && in.izz >= 0.0;
    for (double value : I) good = good && std::isfinite(value);
    if (!good)
      fail(link.name, "impossible inertia", std::to_string(in.mass),
           "finite values, mass and diagonal not negative");
    return moved({in.mass, {0, 0, 0}, I}, rotation(in.origin.rotation), vector(in.origin.position));
  }

  std::string file_;
  std::size_t most_joints_;
  int rim_points_;
  BodyTree body_;
};

}  // namespace

std::vector<Vec3> box_corners(const Vec3& size) {
  std::vector<Vec3> out;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) out.push_back({x * size[0], y * size[1], z * size[2]});
    }
  }
  return out;
}

std::vector<Vec3> cylinder_rims(double radius, double length, int points) {
  std::vector<Vec3> out;
  for (int k = 0; k < points; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / points;
    for (const double z : {-0.5, 0.5})
      out.push_back({radius * std::cos(angle), radius * std::sin(angle), z * length});
  }
  return out;
}

BodyTree body_tree_from_urdf(const std::string& urdf, const std::string& file, int rim_points) {
  return TreeBuilder(*model::parse_urdf_text(urdf, file), file, kMaxBodyJoints, rim_points).take();
}

RobotTree tree_from_urdf(const std::string& urdf, const std::string& file) {
  RobotTree tree =
      TreeBuilder(*model::parse_urdf_text(urdf, file), file, kMaxJoints, 0).take().tree;
  if (tree.joints.empty()) {
    throw InputError(file, 0, "", "no movable joint", "",
                     "at least one revolute, continuous or prismatic joint");
  }
  return tree;
}

}  // namespace sanso::diagnose
