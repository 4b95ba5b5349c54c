// A model folder: robot.urdf and model.toml (docs/model-folder.md). Reading is strict, writing
// reads back the same.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tools/diagnose/model_folder/robot_tree.h"
#include "tools/recording/joint_settings.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

using recording::Actuator;
using recording::JointSettings;

/// One [[effect]] as written. Names of parameters are checked by the effect library
/// (effects/from_model.h).
struct EffectEntry {
  std::string id;
  std::vector<std::string> where;
  std::map<std::string, double> parameters;
  int line = 0;
};

/// A weight that was put on for one recording; apart from its link, whose own mass may be what is
/// in question.
struct AttachedBody {
  int joint = 0;
  BodyInertia body;  // in the joint's frame
};

/// What a floating base stands on.
enum class GroundKind { plane, ramp, jump_ramp, heights };
/// As model.toml says it.
const char* to_string(GroundKind kind);

struct ModelFolder {
  std::string folder;                    // as the user named it; used in messages
  std::string urdf_file = "robot.urdf";  // beside model.toml
  std::string urdf;                      // its text
  bool floating = false;
  int base_line = 0;                               // of model.toml, where `base` stands
  std::array<double, 3> gravity{0.0, 0.0, -9.81};  // m/s^2, world axes
  // command period; held from sample to sample in recordings
  double period_s = 0.01;
  JointSettings joint_default;
  std::vector<JointSettings> joints;  // resolved, one for every joint of `tree`, same order
  GroundKind ground_kind = GroundKind::plane;
  double ground_friction = 0.8;
  std::vector<EffectEntry> effects;
  RobotTree tree;
  std::vector<AttachedBody> payloads;  // of the recording, see with_overrides
  // P gain (p_gain or kp) by joint as model.toml states it, whatever the recording has; see
  // with_overrides. Empty: as in `joints`
  std::vector<double> stated_gain;
  // voltage by joint, likewise [V]
  std::vector<double> stated_voltage;
};

/// Throws files::InputError: file, line, key, what was expected.
ModelFolder read_model_folder(const std::string& folder);
/// The same for text in memory; `name` stands for model.toml in messages.
ModelFolder parse_model(std::string_view toml, std::string_view urdf, const std::string& name);

/// Throws files::InputError for a base that floats: every prediction of tools/diagnose would bolt
/// it down. `reader` is the command that says so.
void require_fixed_base(const ModelFolder& model, const std::string& reader);

/// Text of model.toml that read_model_folder reads back.
std::string model_toml(const ModelFolder& model);
/// Writes robot.urdf and model.toml into `folder` (created when missing), each by rename, so never
/// half.
void write_model_folder(const ModelFolder& model, const std::string& folder);

/// The model as it was during this recording: the sidecar's settings and payloads applied. Throws
/// InputError.
ModelFolder with_overrides(const ModelFolder& model, const recording::Recording& recording);

}  // namespace sanso::diagnose
