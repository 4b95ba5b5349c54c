// Step 0, the data gate: is this a recording at all, of this robot, in these units? Fail-closed:
// one defect refuses the data.
// Works on plain columns, so that it can judge data of any origin; knows no physics beyond the
// joint list.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "tools/diagnose/settings.h"

namespace sanso::diagnose {

/// One column of a recording; NaN = cell empty (not sampled).
struct GateChannel {
  std::string name;  // "q:knee"
  std::span<const double> values;
};

struct GateRecording {
  std::string file;
  std::string condition;
  std::span<const double> t;  // s
  std::vector<GateChannel> channels;
  const GateChannel* find(const std::string& name) const;
};

/// What the gate must know of a joint; zero = not known.
struct GateJoint {
  std::string name;
  bool prismatic = false;
  double lower = 0.0, upper = 0.0;  // limits, rad (m); equal: none
  double speed_limit = 0.0;         // what the actuator can reach at best (no-load speed), rad/s
  double current_limit = 0.0;       // stall current, A
  double torque_limit = 0.0;        // N m
  double voltage = 0.0;             // nominal supply, V
  double position_quantum = 0.0;    // step of the encoder, rad (m)
};

/// A reason to refuse. `row` is the file's data row (0 = first after the header) where it shows
/// first; -1: whole column.
struct Defect {
  std::string file, channel;
  long row = -1;
  std::string defect;   // one of defect:: below
  std::string message;  // value, expectation, next step
};

/// The names of all defects; scripts match on them, so they never change.
namespace defect {
inline constexpr const char* kUnreadable = "unreadable file";
inline constexpr const char* kTooLarge = "file too large";
inline constexpr const char* kEmpty = "empty file";
inline constexpr const char* kHeaderOnly = "header only";
inline constexpr const char* kTooShort = "too short";
inline constexpr const char* kMissingChannel = "missing channel";
inline constexpr const char* kNotANumber = "not a number";
inline constexpr const char* kBackwards = "time runs backwards";
inline constexpr const char* kDuplicateTime = "duplicate time stamp";
inline constexpr const char* kGap = "gap";
inline constexpr const char* kStuck = "stuck channel";
inline constexpr const char* kWrongUnit = "wrong unit";
inline constexpr const char* kWrongSign = "wrong sign";
inline constexpr const char* kSwapped = "swapped joints";
inline constexpr const char* kEncoderWrap = "encoder wrap";
inline constexpr const char* k16BitWrap = "16-bit wrap";
inline constexpr const char* kClipped = "clipped channel";
inline constexpr const char* kShiftedClock = "shifted clock";
inline constexpr const char* kCommandIsCopy = "command is a copy of the position";
inline constexpr const char* kCopyOfFile = "copy of another file";
inline constexpr const char* kNoMotion = "no motion";
}  // namespace defect

/// Measurement noise of a channel, from the recording itself.
struct NoiseLevel {
  std::string channel;
  double quantum = 0.0;  // quantisation step; 0: none found
  // standard deviation of one sample, quantisation included; of a channel that never changes, what
  // its own step makes or what its neighbours of the same kind show
  double sigma = 0.0;
  // AR(4) coefficients in standstill; empty: not enough standstill
  std::vector<double> colour;
};

/// What a joint's motion offers to a diagnosis.
struct Excitation {
  std::string joint;
  double range = 0.0;      // rad
  double speed_rms = 0.0;  // rad/s
  int reversals = 0;       // changes of direction larger than 5 noise levels
  bool moves = false;      // false: effects of this joint are untestable in these data
};

struct GateReport {
  std::vector<Defect> defects;     // not empty: refused
  std::vector<std::string> notes;  // legal, but worth knowing: jitter, glitches, repeats
  std::vector<NoiseLevel> noise;   // the first recording's channels, pooled over recordings
  std::vector<Excitation> excitation;
  bool refused() const { return !defects.empty(); }
};

/// Judges all recordings of one call together (copies and swaps are seen across files).
GateReport inspect(const std::vector<GateRecording>& recordings,
                   const std::vector<GateJoint>& joints, const GateSettings& settings = {});

/// Files that cannot be a recording are refused before they are read: missing, empty, larger than
/// `largest_file`.
std::vector<Defect> inspect_file(const std::string& path, const GateSettings& settings = {});

}  // namespace sanso::diagnose
