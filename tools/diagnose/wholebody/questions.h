// The questions to a floating base, each from residuals that need no integration through a
// contact.
#pragma once

#include <memory>
#include <optional>

#include "tools/diagnose/wholebody/answers.h"
#include "tools/diagnose/wholebody/contacts.h"
#include "tools/diagnose/wholebody/lean.h"
#include "tools/diagnose/wholebody/stance_shown.h"

namespace sanso::diagnose {

/// What a model folder of a floating base says already, beside its shapes and masses: its
/// [[effect]] entries, and what a diagnosis adds.
struct Known {
  double pose_scale = 1.0;                           // recorded base positions over true ones
  double force_scale = 1.0;                          // recorded foot forces over true ones
  V3 acc_bias = V3::Zero(), gyro_bias = V3::Zero();  // IMU axes, m/s^2, rad/s
  V2 slope = V2::Zero();                             // of the floor about world x and y, rad
  V2 pose_tilt = V2::Zero();  // of the true vertical in the poses' axes, the same way
  // by joint, or empty: friction per load, what encoders read too much (rad)
  std::vector<double> load, zero;
  M3 imu_turn = M3::Identity();  // IMU axes from what the IMU's readings are in
};

/// All that a question may need.
struct Asking {
  const WholeBody& body;
  const std::vector<WholeRecording>& recordings;
  Known known;
  WholeSettings settings;
  DecisionSettings decisions;
  ToleranceSettings tolerances;
  unsigned long seed = 1;
  StanceSettings stance = {};
  SmootherSettings smoother = {};
  std::vector<std::string> effects = {};  // of drives and links, that may be named; empty: all
  Chance chance() const { return {settings, decisions, seed}; }
  // group of a moment: the recording where there are several, else a piece of it
  std::size_t group_of(std::size_t recording, double seconds_since_start) const;
};

/// What goes into the patched model.
struct Patch {
  std::optional<double> friction, restitution, pose_scale, mass_share;
  std::optional<V3> imu_turn, acc_bias, gyro_bias;  // turn: recorded axes from assumed ones, rad
  std::optional<V2> slope, pose_tilt;               // beside what is known, rad
  std::vector<EffectEntry> entries;                 // of drives and links, beside what is known
  /// What a later question found, beside what stands here or in its place.
  void take(Patch later);
};

class NamesApart;  // names_apart.h

/// What a question came to.
struct Answered {
  WholeAnswers answers;
  Patch patch;
  // torques tell a heavier link from sensors that read too much, which the feet's sum does not
  bool weighed = false;
  std::optional<StanceShown> shown;         // what drives and links leave
  std::shared_ptr<const NamesApart> apart;  // of drives and links; null: nothing is undecided
  /// What a later question came to; where it weighed, in place of what the feet's sum said.
  void take(Answered later);
};

/// Whether a flight is one: a robot in somebody's hands, or on a stand, touches nothing either.
bool falls(const Asking& asking, const WholeRecording& r, const Span& flight);

/// Free fall: the pace at which base positions fall says their scale; where the base rests says it
/// again.
Answered ask_free_fall(const Asking& asking);
/// Hits and slides of a robot that is one body: restitution and friction.
Answered ask_hits(const Asking& asking);
/// The feet's vertical forces against weight and inertia of the whole.
Answered ask_weight(const Asking& asking);
/// Soles that sink under a load: stiffness of the contact.
Answered ask_sinking(const Asking& asking);
/// The IMU against the base's motion: how it is mounted, what it adds.
Answered ask_imu(const Asking& asking);
/// How the vertical that the IMU feels leans in the axes of the poses; nothing without an
/// accelerometer beside an attitude.
std::optional<LeanFit> imu_vertical(const Asking& asking);
/// Standing soles against the vertical and against slip.
Answered ask_soles(const Asking& asking);

/// Drives and links against each other: position loop, currents, motion.
Answered ask_drives(const Asking& asking);

/// Reads the model's [[effect]] entries into `body` (masses) and what is returned. Throws
/// files::InputError for an effect that a floating base cannot have here.
Known apply_effects(WholeBody& body);
/// The model with what was found.
WholeBody patched(const WholeBody& body, const Patch& patch);

}  // namespace sanso::diagnose
