// What a model predicts beside what was recorded: the N-step loss of the paper (eq. 6), the measure
// of the model everywhere.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "host/learn/episodes/episode.h"
#include "host/model/augmented_model.h"
#include "shared/model/ground.h"
#include "shared/model/step_model.h"

namespace sanso::learn {

inline constexpr int kPredictionSteps = 12;           // N
inline constexpr int kTicksPerStep = kTicksPerUpper;  // one model step is 60 ms
inline constexpr int kSpanTicks = kPredictionSteps * kTicksPerStep;
inline constexpr double kStep_s = kTicksPerStep * kTick_s;

/// A stretch of a recording: state, then what followed. x[0] is given, x[1..steps] are compared;
/// what stands beyond are numbers, never compared.
struct PredictionWindow {
  std::uint32_t trial = 0;
  int steps = kPredictionSteps;  // 1 .. N
  model::State x[kPredictionSteps + 1];
  model::Input u[kPredictionSteps];  // mean of the applied targets over each 60 ms, rad
  // over the 60 ms before x[0]; where they were not recorded u[0]
  model::Input u_before = model::Input::Zero();

  /// Mean of the targets that act during step k, rad, when each acts `lag_s` (at most a step) after
  /// it was applied: exact for targets that change evenly, or only between steps.
  model::Input input(int k, double lag_s) const {
    return acting(k > 0 ? u[k - 1] : u_before, u[k], lag_s);
  }
  static model::Input acting(const model::Input& before, const model::Input& now, double lag_s) {
    // a lag of zero leaves the very bits
    return lag_s > 0.0 ? model::Input(now + lag_s / kStep_s * (before - now)) : now;
  }
};

/// Mean target over the 60 ms that begin at `tick`; nothing when one is missing.
template <class Number>
std::optional<model::Input> mean_target(const std::map<Number, const wire::Observation*>& at,
                                        Number tick) {
  model::Input u = model::Input::Zero();
  for (Number k = 0; k < kTicksPerStep; ++k) {
    const auto found = at.find(tick + k);
    if (found == at.end()) return std::nullopt;
    u += found->second->u_out / kTicksPerStep;
  }
  return u;
}

/// All windows of an episode that start every `stride_ticks` ticks. Windows with a gap in the
/// observations are left out.
std::vector<PredictionWindow> windows_of(const Episode& episode, int stride_ticks = kTicksPerStep);

/// A base that leans more is a fall in progress: not the robot's model.
inline constexpr double kUprightTilt_rad = 0.5;
/// Angle between the base's z axis and the vertical, rad.
double tilt_of(const model::State& x);
/// Windows of an episode without the stretches in which the base leans more than `tilt_limit_rad`.
std::vector<PredictionWindow> upright_windows_of(const Episode& episode,
                                                 double tilt_limit_rad = kUprightTilt_rad,
                                                 int stride_ticks = kTicksPerStep);

/// What a recording of `ticks` (tick ascending; of a trial, or of the hold before it) has for
/// learning when it is too short or too bad for windows of N steps alone: every window, cut to the
/// steps before the base leans more than `tilt_limit_rad`, before a gap or before the end; at least
/// one step each.
std::vector<PredictionWindow> cut_windows_of(const std::vector<wire::Observation>& ticks,
                                             std::uint32_t trial, double tilt_limit_rad,
                                             int stride_ticks = kTicksPerStep);

/// At most `count` of them, spread evenly: keeps the work of identification bounded.
std::vector<PredictionWindow> thinned(const std::vector<PredictionWindow>& windows,
                                      std::size_t count);

/// Mean over windows and their steps of ||x ⊖ x̂||²_W with x̂ from the analytical model, plus the
/// residual network when `residual` is not null. Infinity when a prediction is not finite; 0 for no
/// windows.
double n_step_loss(const std::vector<PredictionWindow>& windows, const model::StepModel& model,
                   const model::Ground& ground, const model::Tangent& weights,
                   const host::ResidualNetwork* residual = nullptr);

/// The errors whose squares it is the sum of, sqrt(W / steps) (x ⊖ x̂): (36 x all steps of all
/// windows). Not finite where a prediction is not.
Eigen::MatrixXd n_step_errors(const std::vector<PredictionWindow>& windows,
                              const model::StepModel& model, const model::Ground& ground,
                              const model::Tangent& weights);

/// One prediction, step by step (for figures): (N + 1) states, the first is window.x[0].
std::vector<model::State> predicted(const PredictionWindow& window, const model::StepModel& model,
                                    const model::Ground& ground,
                                    const host::ResidualNetwork* residual = nullptr);

}  // namespace sanso::learn
