// A model folder whose base floats: what model.toml says beyond a ModelFolder ([imu], [[contact]],
// the ground's own figures), and the shapes of the URDF that can touch.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/model_folder/body_tree.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/settings_of_whole.h"

namespace sanso::diagnose {

/// What touches; empty: nobody states it, a nuisance with a range.
struct ContactMaterial {
  std::optional<double> friction, stiffness, damping;  // -, N/m, N s/m
};

/// A plane, normal to gravity.
struct Ground {
  ContactMaterial material;
  std::optional<double> height;       // m, along the vertical of the recordings' world
  std::optional<double> restitution;  // -
};

/// Where the IMU sits: fixed to the link of joint `joint` (-1: the base).
struct ImuPlace {
  bool given = false;  // false: at the origin of the base link, in its axes
  std::string link;
  Vec3 xyz{0, 0, 0}, rpy{0, 0, 0};  // on that link
  int joint = -1;
  Mat3 R_joint_imu = kIdentity3;
  Vec3 p_joint_imu{0, 0, 0};
};

/// [[contact]]: another material, or another shape, of one link.
struct ContactSetting {
  std::string link;
  ContactMaterial material;
  std::optional<Vec3> box;  // size, m
  std::optional<double> sphere;
  Vec3 xyz{0, 0, 0}, rpy{0, 0, 0};
};

struct WholeBody {
  ModelFolder model;  // floating; its tree may have more than kMaxJoints joints
  std::string root;
  BodyInertia base;
  std::vector<CollisionShape> shapes;
  Ground ground;
  std::vector<ContactSetting> contacts;
  ImuPlace imu;
  std::vector<std::string> notes;  // shapes that are not read

  /// Of the link's shape: [[contact]], else the URDF's <gazebo> tags, else [ground].
  ContactMaterial material_of(const std::string& link) const;
  double mass() const;
};

/// Throws files::InputError: file, line, key, what was expected.
WholeBody read_whole_body(const std::string& folder, const WholeSettings& settings = {});
/// The same for text in memory; `name` stands for model.toml in messages.
WholeBody parse_whole_body(std::string_view toml, std::string_view urdf, const std::string& name,
                           const WholeSettings& settings = {});

/// Text of model.toml that read_whole_body reads back.
std::string whole_body_toml(const WholeBody& body);
/// Writes robot.urdf and model.toml into `folder`, each by rename.
void write_whole_body(const WholeBody& body, const std::string& folder);

/// Rotation of roll, pitch, yaw about fixed axes, as in a URDF.
Mat3 rotation_of_rpy(const Vec3& rpy);

}  // namespace sanso::diagnose
