// The robots that a hidden world can be made of, as one list of links and joints: MuJoCo's model
// and the URDF of the model folder are both written from it, the first from the true figures, the
// second from the nominal ones.
#pragma once

#include <string>
#include <vector>

#include "tools/plant/random.h"
#include "tools/plant/vec.h"

namespace sanso::conceal {

using plant::Random;
using plant::Vec3;

/// A vector as an attribute of MuJoCo's files and of URDF.
std::string text(const Vec3& v);

/// A unit vector, any direction as likely as another.
Vec3 direction(Random& random);

/// A link and the revolute joint that carries it. Frames: the joint's, x forward, z up at zero
/// angle.
struct LinkSpec {
  std::string link, joint;
  int parent = -1;               // index of the parent link; -1 = the fixed base
  Vec3 origin{}, axis{0, 1, 0};  // of the joint, in the parent's frame
  double mass = 0;
  Vec3 com{};
  double inertia[6] = {};            // ixx iyy izz ixy ixz iyz about the COM, link axes, kg m^2
  double lower = -2.6, upper = 2.6;  // joint limits of the URDF; the experiments stay inside
  Vec3 payload_at{};                 // where a payload is screwed on
};

struct RobotSpec {
  std::string name;
  std::vector<LinkSpec> links;
  double amplitude_rad = 0.8;  // of the experiments
  double payload_kg = 0.0;     // of the payload condition; 0: the stand is tilted instead
  int payload_link = 0;
  std::vector<double> posture;  // centre of the experiments, rad
  int size() const { return static_cast<int>(links.size()); }
};

/// "pendulum" (one servo, one rod), "arm" (two links), "op3-stand" (twelve leg joints, torso in a
/// stand).
/// Throws plant::WorldError for any other name.
RobotSpec make_robot(const std::string& name);

/// The same robot as it was really built: mass 3 %, lengths of the COM 2 %, each uniformly inside.
RobotSpec as_built(const RobotSpec& nominal, Random& random);

/// URDF text of the model folder.
std::string to_urdf(const RobotSpec& robot);

/// MuJoCo model; joints carry `armature[j]`; body "<link>_payload" is a point mass that the world
/// can switch on.
std::string to_mjcf(const RobotSpec& robot, const std::vector<double>& armature, double step_s,
                    const Vec3& gravity);

/// Adds rotational inertia about the joint's axis without breaking the triangle inequality.
void add_axis_inertia(LinkSpec& link, double share);

}  // namespace sanso::conceal
