// A robot on a fixed base as a tree of one-degree-of-freedom joints: what robot.urdf says, fixed
// joints merged away.
// Plain numbers only, so that an effect can change any of them; the equations of motion are in
// sim/tree_dynamics.h.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

namespace sanso::diagnose {

using Vec3 = std::array<double, 3>;
using Mat3 = std::array<double, 9>;  // row by row
inline constexpr Mat3 kIdentity3{1, 0, 0, 0, 1, 0, 0, 0, 1};
inline constexpr std::size_t kMaxJoints = 20;

/// Mass properties of one rigid body, in the axes of its link.
struct BodyInertia {
  double mass = 0.0;  // kg
  Vec3 com{0, 0, 0};  // centre of mass from the link's origin              m
  Mat3 about_com{};   // rotational inertia about the centre of mass        kg m^2
  bool operator==(const BodyInertia&) const = default;
};

/// Adds `part` to `whole`, both in the same axes and from the same origin.
void add_body(BodyInertia& whole, const BodyInertia& part);
/// The same body seen from a frame in which its link sits at p with rotation R (link axes into that
/// frame).
BodyInertia moved(const BodyInertia& body, const Mat3& R, const Vec3& p);

/// A joint and the link behind it. Frames: the joint frame has the link's origin; at q = 0 it is
/// fixed in the parent.
struct TreeJoint {
  std::string name;
  std::string link;
  bool prismatic = false;
  int parent = -1;  // index of the joint before it, smaller than its own; -1 = the base
  Mat3 R_parent_joint = kIdentity3;
  Vec3 p_parent_joint{0, 0, 0};  // m, in parent axes
  Vec3 axis{0, 0, 1};            // unit vector, joint axes
  BodyInertia body;
  // position limits of the URDF, rad or m; lower >= upper: none given
  double lower = 0.0, upper = 0.0;
  double effort = 0.0;  // N m or N; 0 = none given
  double speed = 0.0;   // rad/s or m/s; 0 = none given
  bool operator==(const TreeJoint&) const = default;
};

/// Where a URDF link (also one merged away) sits: fixed to the link of joint `joint` (-1 = base).
struct LinkPlace {
  int joint = -1;
  Mat3 R_joint_link = kIdentity3;
  Vec3 p_joint_link{0, 0, 0};
  bool operator==(const LinkPlace&) const = default;
};

struct RobotTree {
  std::string name;
  std::vector<TreeJoint> joints;                 // parents before children
  std::map<std::string, LinkPlace> links;        // every link of the URDF
  int index_of(const std::string& joint) const;  // -1 when there is no such joint
  std::size_t size() const { return joints.size(); }
  bool operator==(const RobotTree&) const = default;
};

/// Reads URDF text. Throws files::InputError naming link or joint; `file` is used in messages.
RobotTree tree_from_urdf(const std::string& urdf, const std::string& file);

/// Matrices row by row: sum, R v, A B.
Vec3 operator+(const Vec3& a, const Vec3& b);
Vec3 rotated(const Mat3& R, const Vec3& v);
Mat3 product(const Mat3& A, const Mat3& B);

}  // namespace sanso::diagnose
