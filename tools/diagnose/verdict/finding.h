// A finding: a name of the library that passed every gate, with its parameters, its rivals and what
// is held against it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/diagnose/explain/incidence.h"
#include "tools/diagnose/explain/select.h"

namespace sanso::diagnose {

/// `unfinished`: the search was interrupted; of a finding, accepted and not judged to the end.
enum class VerdictStatus { confirmed, one_of, present_unnamed, absent, refused, unfinished };
const char* to_string(VerdictStatus status);
/// Of the word that verdict.json has; nothing: there is no such status.
std::optional<VerdictStatus> status_from_string(std::string_view word);

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
  std::vector<std::size_t> joints;  // whose it is, or whose links'; empty: the whole robot's
  std::string regime;               // where in the motion it shows most
  VerdictStatus status = VerdictStatus::confirmed;
  std::map<std::string, VerdictParameter> parameters;
  double p_family = 1.0;
  // share of the prediction error's energy that this effect alone removes, held out
  double heldout_gain = 0.0;
  double heldout_gain_se = 0.0;
  double heldout_gain_low = 0.0;  // bound that chance leaves (moving-block bootstrap)
  double agreed_low = 0.0;        // the same of signed ranks (1: every shot gains)
  std::vector<std::string> one_of;
  std::vector<std::string> terms;  // findings that are terms of one series with this one
  unsigned terms_of = 0;           // Term bits (effects/effect.h) that they share
  bool spans_null = false;         // its interval contains what changes nothing
  bool nearly_null = false;        // DecisionSettings::sure_size times as wide it would
  // a ripple over the angle of which its joint goes through less than LibrarySettings::periods:
  // whatever bends over the angle would look so
  bool unrepeated = false;
  bool chance = false;  // Candidate::random: its scatter takes what no model predicts
  // as much stays without a name that it may be a part of what has none
  bool beside_much = false;
  // a friction beside one, a spring beside one, ... at the same joint that nobody saw repeat: both
  // may be one law that bends over the angle
  std::string bends_with;
  // removes so little of what this one at the same joint does that it may be what that one's law is
  // off by
  std::string rest_of;
  // removes less than what this one does, and is of too uncertain a size to be sure beside it: what
  // is left of a larger finding is no noise, and has no place in an interval
  std::string small_beside;
  // its interval does not lie beyond Effect::law: the model is calibrated by it, nothing is missing
  bool tolerated = false;
  std::vector<Rival> rivals;
  std::vector<IncidenceRow> incidence;
};

/// Parameters that the fit left at a bound of the library, in words; empty: none. What was stopped
/// there is of another size or another structure.
std::string stopped_at_bounds(const Finding& finding);

/// Why a finding is not confirmed: much that stays beside it, an interval that contains the null, a
/// ripple that was not seen to repeat, or one beside it, a larger law that may be off by as much, a
/// size that is uncertain beside a larger finding, a bound, or terms that together describe any
/// torque of the angle; empty: nothing.
std::string reserve(const Finding& finding);

/// The findings with what is said by one of their kind at the same joint (Finding::bends_with and
/// rest_of), and by a larger one anywhere (small_beside).
std::vector<Finding> with_their_kind(std::vector<Finding> findings,
                                     const DecisionSettings& decisions);

/// PRESENT_UNNAMED where it is one of several terms, may be nothing or a part of another law, or
/// stands beside much; ONE_OF where several names are left; CONFIRMED where one is and no bound
/// stopped it; else PRESENT_UNNAMED.
VerdictStatus status_of(const Finding& finding);

/// Of a verdict that was reached: PRESENT_UNNAMED where something stays without a name or a finding
/// is no certain one; ABSENT without a finding; ONE_OF where one of them is a set; else CONFIRMED.
VerdictStatus overall_status(const std::vector<Finding>& findings, bool something_unnamed);

/// One finding for every accepted effect that no residual contradicts.
std::vector<Finding> findings_of(const Library& library, const Selection& selection,
                                 const Regimes& regimes);

/// What a search that is not done has accepted, with the intervals of its last fit: no rival was
/// tried in its place, no residual was asked. Simulates nothing.
std::vector<Finding> accepted_so_far(const Library& library, const Selection& selection);

/// Term bits (effects/effect.h) of a candidate on this tree. What a link does to a joint that hangs
/// on the base is a function of that joint's motion alone; further out, the motion of other joints
/// tells masses from springs and rotors.
unsigned terms_of(const Candidate& candidate, const std::vector<TreeJoint>& tree);

/// The final intervals (wider than those by which a name is accepted, and `stretch` times as wide
/// as told) of all that was fitted contain the null.
bool spans_null(const Candidate& candidate,
                const std::map<std::string, VerdictParameter>& parameters, double stretch = 1.0);

/// Whether nothing of a finding lies beyond what its effect's law tolerates at all of its joints.
/// An amplitude is as small as the nearest point of its components' intervals: its phase is free,
/// so that no component alone says how large it is.
bool is_tolerated(const Finding& finding, const Candidate& candidate, const SimParams& nominal,
                  const ToleranceSettings& tolerances);

}  // namespace sanso::diagnose
