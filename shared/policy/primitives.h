// Dynamic movement primitives of the lower layer: the set that is uploaded before a trial, and its
// playback at 10 ms.
// Equations: [Ijspeert 2013] for the scalars, [Ude 2014] for the base orientation, with a phase
// that is linear in time.
// Fitting a set to a trajectory is the host's work (host/motion/dmp_fit.h).
//
//   y'' = lambda^2 (g - y) - 2 lambda y' + f / tau^2          lambda = alpha_z / (2 tau):
//   critically damped
//   w'  = lambda^2 log(g quat*) - 2 lambda w + f / tau^2      rotation error and angular velocity
//   in WORLD axes
//
// discrete: tau = duration; basis functions evenly spaced over it; f fades out between fade_start
// and 1, so y ends at g.
// rhythmic: tau = period / (2 pi); y moves about g plus a linear drift (distance walked).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/base/status.h"
#include "shared/model/state_layout.h"

namespace sanso::policy {

// base x, y, z [m], then the joints [rad]
inline constexpr int kNumScalarPrimitives = 3 + model::kNumJoints;
inline constexpr int kMaxBasis = 256;
inline constexpr double kAlphaZ = 25.0;  // [Ijspeert 2013]; beta_z = alpha_z / 4
inline constexpr double kMaxPrimitiveDuration_s = 60.0;
inline constexpr double kPrimitiveStep_s = 0.01;  // one tick

enum class PrimitiveForm : std::uint8_t { discrete = 1, rhythmic = 2 };

/// One scalar degree of freedom. Units m or rad (base, joint).
struct ScalarPrimitive {
  double start = 0.0;       // y(0)
  double start_rate = 0.0;  // y'(0)                                        unit/s
  double goal = 0.0;        // g: end of a discrete motion, centre of a rhythmic one at t = 0
  double drift = 0.0;       // rhythmic only: the centre moves at this rate  unit/s
  std::array<float, kMaxBasis> weights{};
};

/// Base orientation. Rates and forcing in world axes.
struct OrientationPrimitive {
  math::Quat start = math::quat_identity();
  math::Vec3 start_rate = math::Vec3::Zero();  // w_base_in_world at t = 0   rad/s
  math::Quat goal = math::quat_identity();
  std::array<std::array<float, 3>, kMaxBasis> weights{};
};

struct PrimitiveSet {
  PrimitiveForm form = PrimitiveForm::discrete;
  int num_basis = 2;        // 2 .. kMaxBasis, common to all degrees of freedom
  double duration_s = 1.0;  // of the whole motion
  double period_s = 1.0;    // rhythmic: of one cycle
  double fade_start = 0.9;  // discrete: fraction of the duration where the forcing begins to fade
  std::array<ScalarPrimitive, kNumScalarPrimitives> scalar{};
  OrientationPrimitive orientation;

  double tau() const;          // s
  int duration_ticks() const;  // whole 10 ms ticks in the motion
  /// State at t = 0: what the robot has to be in before the motion starts.
  model::State start_state() const;
};

/// The basis functions that matter at one time; all others are below exp(-25).
struct BasisWindow {
  static constexpr int kHalfWidth = 5;
  std::array<std::int16_t, 2 * kHalfWidth + 1> index{};
  std::array<double, 2 * kHalfWidth + 1> activation{};  // psi_i / sum psi, times the fade
  int count = 0;                                        // 0 once a discrete motion is over
};
/// The window at t [s] of the motion; empty after the end of a discrete one.
BasisWindow active_basis(const PrimitiveSet& set, double t_s);

/// Plays a set tick by tick. Scalars advance by the exact solution for a forcing that is linear
/// over the tick, the orientation by 1 ms inner steps. Cost about 2 us a tick, no allocation.
class PrimitivePlayer {
 public:
  /// Starts at t = 0. `set` must be valid (see validate) and outlive the player.
  void reset(const PrimitiveSet& set);
  /// Advances by one tick of 10 ms. Needs reset.
  void step();
  /// x_DMP: base pose, joints, base velocity in world, base angular velocity in base axes, joint
  /// rates.
  const model::State& state() const { return x_; }
  /// u_DMP: the joint angles of x_DMP.
  model::Input input() const { return model::joints(x_); }
  int tick() const { return tick_; }
  double time_s() const { return tick_ * kPrimitiveStep_s; }
  bool finished() const { return set_ != nullptr && tick_ >= set_->duration_ticks(); }

 private:
  struct Forcing {  // f / tau^2 of every degree of freedom
    std::array<double, kNumScalarPrimitives> scalar{};
    math::Vec3 orientation = math::Vec3::Zero();
  };
  Forcing forcing_at(double t_s) const;
  void step_scalar(int i, double a0, double a1);
  void step_orientation(const math::Vec3& a0, const math::Vec3& a1);
  void compose_state();

  const PrimitiveSet* set_ = nullptr;
  int tick_ = 0;
  double lambda_ = 0.0;                           // 1/s
  double decay_ = 0.0;                            // exp(-lambda * 10 ms)
  Forcing forcing_;                               // at the current tick
  std::array<double, kNumScalarPrimitives> y_{};  // without drift
  std::array<double, kNumScalarPrimitives> v_{};
  math::Quat quat_world_base_ = math::quat_identity();
  math::Vec3 w_base_in_world_ = math::Vec3::Zero();
  model::State x_ = model::neutral_state();
};

/// ok, or out_of_range when a number is not finite or outside what a robot of this size can be
/// asked to do.
Status validate(const PrimitiveSet& set);

/// Upload format, little-endian; docs/wire.md. 4 bytes of head, then the fields of PrimitiveSet in
/// order.
inline constexpr std::size_t kMaxPrimitiveBytes =
    4 + 3 * 8 + kNumScalarPrimitives * (4 * 8 + kMaxBasis * 4) + 11 * 8 + kMaxBasis * 3 * 4;
std::size_t encoded_size(const PrimitiveSet& set);
/// Writes the set and returns the bytes used; 0 when `out` is too small.
std::size_t to_bytes(const PrimitiveSet& set, std::span<std::uint8_t> out);
/// Reads and validates; `set` is unspecified unless ok. Exactly one set, no trailing bytes.
Status from_bytes(std::span<const std::uint8_t> bytes, PrimitiveSet& set);

}  // namespace sanso::policy
