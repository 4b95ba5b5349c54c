// URDF text to RobotTree. The XML is read by urdfdom; what the simulator cannot do is refused by
// name.
#include <cmath>

#include "host/model/urdf_text.h"
#include "shared/files/input_error.h"
#include "tools/diagnose/model_folder/robot_tree.h"

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
  TreeBuilder(const urdf::ModelInterface& model, std::string file) : file_(std::move(file)) {
    tree_.name = model.getName();
    add_link(*model.getRoot(), -1, kIdentity3, {0, 0, 0});
    if (tree_.joints.empty())
      fail("", "no movable joint", "", "at least one revolute, continuous or prismatic joint");
  }
  RobotTree take() { return std::move(tree_); }

 private:
  [[noreturn]] void fail(const std::string& where, const char* defect, const std::string& value,
                         const char* expected) const {
    throw InputError(file_, 0, where, defect, value, expected);
  }

  /// Adds a link that sits at (R, p) in the frame of joint `joint`, then everything behind it.
  void add_link(const urdf::Link& link, int joint, const Mat3& R, const Vec3& p) {
    tree_.links[link.name] = {joint, R, p};
    if (link.inertial && joint >= 0) {
      add_body(tree_.joints[static_cast<std::size_t>(joint)].body, moved(inertia(link), R, p));
    }
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
    if (tree_.size() >= kMaxJoints)
      fail(joint.name, "too many joints", "", "at most 20 movable joints");
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
    tree_.joints.push_back(t);
    add_link(child, tree_.size() - 1, kIdentity3, {0, 0, 0});
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
  RobotTree tree_;
};

}  // namespace

RobotTree tree_from_urdf(const std::string& urdf, const std::string& file) {
  return TreeBuilder(*model::parse_urdf_text(urdf, file), file).take();
}

}  // namespace sanso::diagnose
