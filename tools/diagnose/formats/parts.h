// What the three writers share: the model as the simulator has it, places as numbers, and the list
// of what a format leaves out.
#pragma once

#include <string>
#include <vector>

#include "host/model/urdf_text.h"
#include "tools/diagnose/formats/formats.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

enum Format : unsigned { kMjcf = 1, kUrdf = 2, kSdf = 4 };

struct Pose {
  Mat3 R = kIdentity3;
  Vec3 p{0, 0, 0};
};
/// Pose of b's axes where b is in a's axes and a in those of the result.
Pose operator*(const Pose& a, const Pose& b);

/// A shape of the model's own URDF, where its link has been merged into the one that moves.
struct Shape {
  int joint = -1;  // of the link that carries it; -1: the base
  Pose pose;       // in the axes of that link
  urdf::GeometrySharedPtr geometry;
};

struct Parts {
  SimParams params;  // effects applied; payloads that are on from the beginning in their bodies
  std::string root;  // link of the base
  std::vector<Shape> shapes;
};
/// Throws files::InputError for a base that floats, and for a URDF that cannot be read.
Parts parts_of(const ModelFolder& model);

/// Of a joint; -1: of the base.
std::string link_name(const Parts& parts, int joint);

/// What the model has and `format` has not.
std::vector<std::string> lost_in(Format format, const SimParams& params);
/// The same as lines of an XML comment, with what the file is.
std::string head_comment(const std::string& what, const std::vector<std::string>& lost);

/// As XML attributes have them, 17 digits: a number; three with spaces between; a rotation as unit
/// quaternion; roll, pitch, yaw of a rotation, rad (R = Rz Ry Rx).
std::string number(double value);
std::string numbers(const Vec3& v);
std::string quaternion(const Mat3& R);  // w x y z
std::string roll_pitch_yaw(const Mat3& R);

/// Torque of a servo as gains: kp (u - q) - kd dq within `limit`, and `damping` whatever it does.
struct LinearServo {
  double gain = 0.0;  // on a torque command
  double kp = 0.0, kd = 0.0, damping = 0.0;
  double limit = kNone;
};
/// At the joint, its effects applied; without a goal of its own kp and kd are zero.
LinearServo linear_servo(const SimParams& params, std::size_t joint);

}  // namespace sanso::diagnose
