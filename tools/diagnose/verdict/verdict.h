// What a diagnosis says: the content of verdict.json, and nothing else. Field names are the file's
// keys (stable).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/explain/incidence.h"
#include "tools/diagnose/gate/gate.h"

namespace sanso::diagnose {

enum class VerdictStatus { confirmed, one_of, present_unnamed, absent, refused };
const char* to_string(VerdictStatus status);

/// A fitted parameter with its 95 % interval.
struct VerdictParameter {
  double value = 0.0, low = 0.0, high = 0.0;
  std::string unit;
  bool at_bound = false;  // the fit ended at the library's bound: the interval is one-sided
};

/// Another name for the same data, with its held-out score.
struct Rival {
  std::string effect;
  std::vector<std::string> where;
  double heldout_gain = 0.0;  // share of the prediction error's energy removed on held-out data
  // how far behind the best, in standard errors of the paired difference
  double behind_in_se = 0.0;
  double similarity = 0.0;  // |correlation| of the two effects' signatures in these data
  std::string said_wrong;   // the residual that it should have changed and did not; empty: none
};

struct Finding {
  std::string effect, family;
  std::vector<std::string> where;
  std::string regime;  // where in the motion it shows most
  VerdictStatus status = VerdictStatus::confirmed;
  std::map<std::string, VerdictParameter> parameters;
  double p_family = 1.0;
  // share of the prediction error's energy that this effect alone removes, held out
  double heldout_gain = 0.0;
  double heldout_gain_se = 0.0;
  double heldout_gain_low = 0.0;  // bound that chance leaves (moving-block bootstrap)
  std::vector<std::string> one_of;
  std::vector<std::string> terms;  // findings that are terms of one series with this one
  unsigned terms_of = 0;           // Term bits (effects/effect.h) that they share
  bool spans_null = false;         // its interval contains what changes nothing
  std::vector<Rival> rivals;
  std::vector<IncidenceRow> incidence;
};

/// Parameters that the fit left at a bound of the library, in words; empty: none. What was stopped
/// there is of another size or another structure.
std::string stopped_at_bounds(const Finding& finding);

/// Why a finding is not confirmed: an interval that contains the null, a bound, or terms that
/// together describe any torque of the angle; empty: nothing.
std::string reserve(const Finding& finding);

/// PRESENT_UNNAMED where it is one of several terms or may be nothing; ONE_OF where several names
/// are left; CONFIRMED where one is and no bound stopped it; else PRESENT_UNNAMED.
VerdictStatus status_of(const Finding& finding);

struct LocationCell {
  std::string where, regime;
  double share = 0.0;    // of the residual energy beyond noise
  double lift = 0.0;     // energy density inside over outside
  double mean = 0.0;     // signed mean of the whitened residual
  double q_value = 1.0;  // false discovery rate at which this cell is called
  double rows = 0.0;     // samples in the cell
};

/// One joint (or "all") at one horizon, on recordings that were not fitted.
struct FitScore {
  double nominal = 0.0, patched = 0.0, noise = 0.0;
  // (nominal^2 - patched^2) / (nominal^2 - noise^2), energies; 0 when nothing to explain
  double explained() const;
};

struct Untestable {
  std::string effect, because;
};

/// Smallest size that these data would have shown (80 % power at the family-wise level).
struct Detectable {
  std::string effect, where, parameter, unit;
  double size = 0.0;
};

/// What an experiment changes: a setting of the robot or its bench, or the motion commanded.
enum class ExperimentKind { setting, motion };
const char* to_string(ExperimentKind kind);

struct NextExperiment {
  std::string what;  // in words
  ExperimentKind kind = ExperimentKind::setting;
  std::vector<std::string> separates;
  double nats_per_second = 0.0;
  double seconds_to_100_to_1 = 0.0;
  std::string motion_file;  // CSV with the command, when the motion changes
};

/// A short stretch of a recording that the last model misses by far more than its other errors.
struct Stretch {
  std::string recording, where;
  double from = 0.0, until = 0.0;  // s, the recording's own clock
  double level = 0.0;              // RMS of the position error, noise levels
};

/// Where what has no name shows: the missing torque, the velocity channel against the position
/// channel, short stretches, or no more than the level of the position error.
enum class ShowsIn { torque, velocity_channel, stretches, position };
const char* to_string(ShowsIn where);

struct Unexplained {
  ShowsIn shows_in = ShowsIn::position;
  // cross-validated share of it that joint state predicts (torque, velocity channel)
  double predictable = 0.0;
  double p = 1.0;
  // of the original prediction error beyond noise, still there after the patch
  double energy_share = 0.0;
  std::string where, regime;
  std::string formula;  // sparse regression's answer: a description of the shape, not a name
  std::string nearest_effect;
};

struct Verdict {
  bool mismatch = false;
  VerdictStatus status = VerdictStatus::absent;
  std::string answer;  // one sentence
  std::vector<Finding> findings;
  std::vector<LocationCell> locations;
  // horizon -> "all" | channel -> score
  std::map<std::string, std::map<std::string, FitScore>> heldout;
  std::vector<std::string> heldout_recordings;
  std::vector<Defect> refused;
  std::vector<Untestable> untestable;
  std::vector<Detectable> detectable;
  std::optional<NextExperiment> next_experiment;
  std::optional<Unexplained> unexplained;
  std::vector<Stretch> stretches;  // strongest first
  std::vector<std::string> notes;
  std::map<std::string, std::string> data_hash;  // file -> hash
  unsigned long seed = 0;
};

/// The text of verdict.json.
std::string verdict_json(const Verdict& verdict);

}  // namespace sanso::diagnose
