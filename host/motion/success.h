// What "succeeded" means for a motion: named measures of an episode against bounds that stand in
// the motion's file.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/motion/trajectory.h"
#include "shared/model/ground.h"

namespace sanso::motion {

/// One moment of a trial as somebody outside the controller saw it (an emulated world, a tracking
/// system). Fields that nobody measured stay NaN; a clause that needs them then says so and counts
/// as failed.
struct EpisodeSample {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  // true state, in the frame of the reference
  model::State x = model::neutral_state();
  // lowest sole corner above the ground, right and left
  std::array<double, 2> foot_clearance_m = {kUnknown, kUnknown};
  std::array<double, 2> foot_load_N = {kUnknown, kUnknown};  // normal force
  std::array<Eigen::Vector2d, 2> foot_m = {Eigen::Vector2d::Constant(kUnknown),
                                           Eigen::Vector2d::Constant(kUnknown)};
};

struct MotionEpisode {
  double dt_s = 0.01;
  double cost = 0.0;                   // J of the trial
  bool completed = false;              // ran to its last tick
  std::vector<EpisodeSample> samples;  // sample k at k * dt_s of the motion
};

/// The part of a motion in which it moves, without the standing before and after.
struct Window {
  double from_s = 0.0, to_s = std::numeric_limits<double>::infinity();
};

/// `measure` has to be at least or at most a bound (either or both). A clause that is waived is
/// evaluated and shown, but a motion may succeed without it; `waived` says why the robot cannot
/// hold it.
inline constexpr double kUnloaded_N = 1.0;  // a foot that carries less is in the air

struct Clause {
  std::string measure;
  std::optional<double> at_least, at_most;
  std::string waived = {};
};

/// The bound is in the unit of the measure (measures.h).
inline Clause at_least(const char* measure, double bound) { return {measure, bound, {}}; }
inline Clause at_most(const char* measure, double bound) { return {measure, {}, bound}; }

struct ClauseResult {
  Clause clause;
  double value = 0.0;  // NaN: could not be measured
  bool holds = false;
  bool counts_against() const { return !holds && clause.waived.empty(); }
  std::string text() const;  // "depth_share 0.62, at least 0.7: failed"
};

struct Verdict {
  std::vector<ClauseResult> clauses;
  bool succeeded() const;
  /// Text of the clauses that failed; empty when the motion succeeded.
  std::vector<std::string> failures() const;
};

/// Names, units and meaning of all measures, for documentation and error messages.
struct MeasureInfo {
  std::string name, meaning;
};
std::vector<MeasureInfo> known_measures();

/// Evaluates every clause. Throws std::invalid_argument for a measure that does not exist (the
/// loader has checked).
Verdict evaluate(const std::vector<Clause>& clauses, const MotionEpisode& episode,
                 const Trajectory& reference, const Window& window,
                 const model::Ground& ground = model::make_plane());

}  // namespace sanso::motion
