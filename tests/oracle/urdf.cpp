// Links of a URDF to bodies of the tree: what is rigidly joined becomes one body.
#include "tests/oracle/urdf.h"

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <sstream>

#include "host/model/urdf_text.h"
#include "shared/files/input_error.h"

namespace sanso::model {
namespace {

using files::InputError;

/// A link's frame as seen from the moved link (or base) that it is rigidly joined to.
struct Placement {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();
};

Vec3 vector_of(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }
Placement placement_of(const urdf::Pose& pose) {
  const urdf::Rotation& q = pose.rotation;
  return {Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized().toRotationMatrix(),
          vector_of(pose.position)};
}
Placement behind(const Placement& a, const Placement& b) { return {a.R * b.R, a.p + a.R * b.p}; }

class TreeReader {
 public:
  TreeReader(std::string file, Base base) : file_(std::move(file)) {
    robot_.tree.floating = base == Base::floating;
  }

  UrdfRobot read(const urdf::ModelInterface& model) {
    add_link(*model.getRoot(), -1, {});
    if (robot_.joint_names.empty())
      fail(model.getName(), "no movable joint", "", "a revolute, continuous or prismatic joint");
    return std::move(robot_);
  }

 private:
  [[noreturn]] void fail(const std::string& where, const char* defect, const std::string& value,
                         const char* expected) const {
    throw InputError(file_, 0, where, defect, value, expected);
  }

  /// Joins `link`, which stands at `at` in the frame of tree link `carrier` (-1 = base), then all
  /// behind it.
  void add_link(const urdf::Link& link, int carrier, const Placement& at) {
    if (link.inertial) {
      LinkInertia& sum = carrier < 0 ? robot_.tree.base
                                     : robot_.tree.joints[static_cast<std::size_t>(carrier)].link;
      sum = combined(sum, inertia(link, at));
    }
    for (const auto& joint : link.child_joints) {
      const Placement joint_at = behind(at, placement_of(joint->parent_to_joint_origin_transform));
      const urdf::Link& child = child_of(link, *joint, file_);
      if (joint->type == urdf::Joint::FIXED) {
        add_link(child, carrier, joint_at);
      } else {
        add_link(child, add_joint(*joint, carrier, joint_at), {});
      }
    }
  }

  int add_joint(const urdf::Joint& joint, int carrier, const Placement& at) {
    const bool revolute =
        joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
    if (!revolute && joint.type != urdf::Joint::PRISMATIC) {
      fail(joint.name, "joint type not supported", "", "revolute, continuous, prismatic or fixed");
    }
    TreeJoint t;
    t.parent = carrier;
    t.kind = revolute ? JointKind::revolute : JointKind::prismatic;
    t.R_parent_link0 = at.R;
    t.p_parent_link0 = at.p;
    t.axis = vector_of(joint.axis);
    if (!(t.axis.norm() > 1e-9)) fail(joint.name, "axis of no length", "", "a unit vector");
    t.axis.normalize();
    if (!robot_.tree.joints.try_push(t))
      fail(joint.name, "too many joints", "", "at most 32 movable joints");
    robot_.joint_names.push_back(joint.name);
    return robot_.tree.num_joints() - 1;
  }

  LinkInertia inertia(const urdf::Link& link, const Placement& at) const {
    const urdf::Inertial& in = *link.inertial;
    const Placement com = behind(at, placement_of(in.origin));
    Mat3 I;
    I << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
    if (!(std::isfinite(in.mass) && in.mass >= 0.0 && I.allFinite() &&
          I.diagonal().minCoeff() >= 0.0)) {
      fail(link.name, "impossible inertia", std::to_string(in.mass),
           "finite values, mass and diagonal not negative");
    }
    return {in.mass, com.p, com.R * I * com.R.transpose()};
  }

  std::string file_;
  UrdfRobot robot_;
};

}  // namespace

UrdfRobot parse_urdf(const std::string& text, const std::string& name, Base base) {
  return TreeReader(name, base).read(*parse_urdf_text(text, name));
}

UrdfRobot read_urdf(const std::string& path, Base base) {
  std::ifstream file(path);
  if (!file) throw InputError(path, 0, "", "cannot be opened", "", "a readable URDF file");
  std::ostringstream text;
  text << file.rdbuf();
  return parse_urdf(text.str(), path, base);
}

}  // namespace sanso::model
