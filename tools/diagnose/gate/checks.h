// The single checks of the gate; each returns the defects it finds. All limits stand in
// GateSettings, with their reasons.
#pragma once

#include <iterator>
#include <optional>
#include <utility>

#include "tools/diagnose/gate/gate.h"

namespace sanso::diagnose::gate {

inline constexpr double kDegree = 57.29577951308232;

using Joints = std::vector<GateJoint>;
/// Adds what a check found, if anything.
inline void append(std::vector<Defect>& to, std::optional<Defect> found) {
  if (found) to.push_back(std::move(*found));
}
inline void append(std::vector<Defect>& to, std::vector<Defect> found) {
  to.insert(to.end(), std::make_move_iterator(found.begin()), std::make_move_iterator(found.end()));
}

/// Adds what speaks against the velocity of a joint by its position; where no command vouches for
/// the position, the same of that.
inline void append_either(std::vector<Defect>& to, const GateRecording& r, const GateJoint& joint,
                          std::optional<Defect> found) {
  const bool either =
      found && found->channel == "dq:" + joint.name && r.find("u:" + joint.name) == nullptr;
  append(to, found);
  if (!either) return;
  found->channel = "q:" + joint.name;
  found->message = "or the other way round: " + found->message;
  append(to, std::move(found));
}

/// Too few rows, or seconds, to ask anything.
std::vector<Defect> check_size(const GateRecording& r, const GateSettings& settings);
/// t is no number, goes back, stands still, or has a gap; the first of each.
std::vector<Defect> check_time(const GateRecording& r, const GateSettings& settings);
/// No joint of the model has a position; a channel is infinite somewhere.
std::vector<Defect> check_required(const GateRecording& r, const Joints& joints,
                                   const GateSettings& settings);
/// An angle that jumps by one turn; a 16-bit register that was logged as unsigned.
std::vector<Defect> check_wraps(const GateRecording& r, const Joints& joints,
                                const GateSettings& settings);
/// Positions with flat tops at the ends of what they reach, entered and left at speed.
std::vector<Defect> check_clipping(const GateRecording& r, const Joints& joints,
                                   const GateSettings& settings);
/// A position that hangs while command or velocity say that the joint moves.
std::vector<Defect> check_stuck(const GateRecording& r, const Joints& joints,
                                const GateSettings& settings);

/// A position stood exactly still and is elsewhere from one row to the next: it was not read
/// meanwhile, though it was driven; or whole rows were written again, several times.
std::vector<Defect> check_resumed(const GateRecording& r, const Joints& joints,
                                  const GateSettings& settings);
/// Channels that are too large or too small for SI: by the model's limits, and by each other.
std::vector<Defect> check_units(const GateRecording& r, const Joints& joints,
                                const GateSettings& settings);
/// Joints of which one has the other's velocity, d(q_i)/dt = dq_j, and not its own: exchanged
/// columns of a robot under torque too. Asked before signs, which those contradict as well.
std::vector<Defect> check_velocity_swaps(const GateRecording& r, const Joints& joints,
                                         const GateSettings& settings);
/// A goal that is a copy of the position; a position that moves against its goal; joints of which
/// one follows the other's goal.
std::vector<Defect> check_commands(const GateRecording& r, const Joints& joints,
                                   const GateSettings& settings);
/// A command that the log cuts off: the position goes on beyond its flat tops.
std::vector<Defect> check_clipped_commands(const GateRecording& r, const Joints& joints,
                                           const GateSettings& settings);
/// Commands beyond a limit of the model that the joint does not follow, in words: legal.
std::vector<std::string> unfollowed_commands(const GateRecording& r, const Joints& joints);
/// Command against answer and position against velocity.
std::vector<Defect> check_clocks(const GateRecording& r, const Joints& joints,
                                 const GateSettings& settings);
/// A velocity whose delay is another in one recording.
std::vector<Defect> check_clocks_between(const std::vector<GateRecording>& recordings,
                                         const Joints& joints, const GateSettings& settings);
/// Recordings whose positions are equal row by row, whatever their names and clocks.
std::vector<Defect> check_copies(const std::vector<GateRecording>& recordings);

/// Median sampling interval [s].
double sampling_interval(std::span<const double> t);
/// In words, where intervals vary by more than a tenth: legal. Empty: they do not.
std::string uneven_sampling(const std::string& file, std::span<const double> t);

/// x without isolated single-sample outliers: the median of five takes their place. A sample is one
/// where it leaves that median by more than the channel's usual departures, a few counts and the
/// steps of its neighbours, so that no count that flickers and no turning point is. Empty cells
/// stay empty and are no neighbours.
std::vector<double> without_glitches(std::span<const double> x, int* replaced = nullptr,
                                     const GateSettings& settings = {});

}  // namespace sanso::diagnose::gate
