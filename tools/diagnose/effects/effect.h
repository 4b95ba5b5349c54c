// One hypothesis about missing physics: a small struct that changes simulation parameters at one
// port, and everything a diagnosis must know about it. At its null value it changes nothing, bit
// for bit.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/diagnose/effects/effort_columns.h"
#include "tools/diagnose/effects/whole_figures.h"
#include "tools/diagnose/settings.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

enum class Family { friction, transmission, mass, electrical, timing, sensor, contact, external };
enum class Port {
  clock,
  command_path,
  firmware,
  electrical,
  transmission,
  rigid_body,
  contact,
  external,
  sensor
};
enum class Scope { joint, link, robot };  // what `where` names: joints, links, nothing
std::string_view to_string(Family family);
std::string_view to_string(Scope scope);

/// Bounds and typical sizes in the library are those of an XM430-W350 (4.1 N m, 4.8 rad/s). For
/// another joint they are multiplied by what the joint is in comparison.
enum class Unit {
  none,
  torque,
  speed,
  acceleration,
  viscous,
  drag,
  inertia,
  angle,
  stiffness,
  compliance,
  per_torque,
  per_angle,
  current,
  length,
  force,
  reach
};

/// Null of limits (speed, current): not switched on. Finite so that files and fits can hold it;
/// never scaled.
inline constexpr double kOff = 1e6;

/// What a parameter says, for the search of where a fit begins: no derivative leads to an order or
/// a place from afar.
enum class Role {
  size,   // how much
  order,  // periods in a turn: tried one by one around the probed ones
  // of a signal that is sampled or held, so that its derivative misses the jumps: tried in halving
  // steps
  delay,
  instant,   // of a recording, from which on: tried on a grid
  event,     // of a recording, at which something short begins: tried where errors stand alone
  duration,  // of an event: its edges are tried in halving steps
  filter,    // a time constant: where the filter runs is not known, in the device or row by row
  // of the joint: a probe's sign says from which end of its motion; tried on a grid between the
  // ends
  position,
};

struct EffectParameter {
  std::string_view name;
  std::string_view unit;  // SI; for prismatic joints read m for rad, N for N m, kg for kg m^2
  double null = 0.0;      // nothing changes
  double low = 0.0, high = 0.0;
  double typical = 1.0;  // a step at which it matters: the scale of the fit's coordinate
  Unit scale = Unit::none;
  bool structural = false;  // not fitted by derivatives: stays what the probe says
  Role role = Role::size;
};

/// Residuals of the method page (3.3) that an effect changes.
enum Residual : unsigned {
  kR1 = 1,
  kR2 = 2,
  kR3 = 4,
  kR4 = 8,
  kR5 = 16,
  kR6 = 32,
  kR7 = 64,
  kR8 = 128
};

/// What an effect's torque at its own joint is a function of, alone: the angle, the acceleration,
/// how far the joint has slipped since it turned round (springs that slide one after the other make
/// any such torque: Iwan 1966). Two effects of one kind at one joint are terms of a series that
/// describes any such torque, and so no causes.
enum Term : unsigned { kOfAngle = 1, kOfAcceleration = 2, kOfSlip = 4 };

/// Kinds of missing information that make an effect untestable.
enum Need : unsigned {
  kCommand = 1,       // an actuator that follows a command
  kPositionLoop = 2,  // dc_servo or position_pd
  kMotorModel = 4,    // dc_servo
  kTorqueLimit = 8,   // dc_servo, or a torque_limit in the model
  kTemperature = 16,  // temperature recorded, or dc_servo (its heating is then estimated)
  kVelocity = 32,     // a dq: column
  kTwoJoints = 64,    // at least two joints
  kGround = 128,      // floating base and ground contact
  kImu = 256,         // imu columns on a floating base
};

/// Something a person can do to separate this effect from its look-alikes; settings come before
/// motions.
struct Experiment {
  enum class Kind { setting, channel, motion } kind;
  std::string_view what;
};

/// The keys of [joint.<name>] in model.toml that a parameter of an effect is: an effect of that
/// size and a nominal model with the keys changed are the same robot.
struct SettingChange {
  enum class How { added, multiplied } how{};
  std::vector<double JointSettings::*> keys{};  // changed alike; empty: no key says it
  std::optional<Actuator> only{};               // whose keys they are; empty: of every actuator
};

/// Whether `sanso identify` fits a parameter.
enum class Identified {
  never,
  always,
  // of what acts as one number with a gain: only at joints under torque, which have no gain
  under_torque
};

/// What a nominal model states with finite accuracy, so that it may be wrong by it without anything
/// being missing: a quantity of every joint along a direction of an effect's parameters.
struct Tolerance {
  std::string_view name{};  // "mass": as a report says it before "of <joint>"
  int order = 0;            // among the quantities of a joint: sums are formed in this order
  double ToleranceSettings::*deviation = nullptr;
  /// What one unit is in the effect's parameters; empty: this joint has no such quantity.
  std::function<std::vector<double>(const SimParams&, std::size_t joint)> direction{};
  double sliding = 1.0;  // times the deviation at a joint that slides
  bool common = false;   // one number for all joints
};

/// What an effect may be of and still be no finding: laws of one name differ by as much, or nobody
/// states the figure better.
struct Law {
  double ToleranceSettings::*within = nullptr;  // null: every size is a finding
  // that it limits: one, or the components of an amplitude; all but those of `shape` stay at their
  // null beside them
  std::vector<std::size_t> parameters{};
  std::vector<std::size_t> shape{};  // of any value: how, not how much
  /// What one of the size is in the tolerance's unit; 0: at this joint nothing is tolerated.
  std::function<double(const SimParams&, std::size_t joint)> unit{};
};

struct Effect {
  std::string_view id{};    // stable
  std::string_view code{};  // row of the method page, "F1"
  std::string_view name{};  // in words
  std::string_view form{};  // formula in the names of the parameters
  Family family{};
  Port port{};
  Scope scope{};
  std::vector<EffectParameter> parameters{};
  bool smooth = true;  // derivatives at the null say something; otherwise only probes do
  // chance decides what it does to a recording: judged by scatter, its first parameter the size
  bool random = false;
  unsigned terms = 0;  // Term bits; of a link: where its joint hangs on the base
  // parameter vectors (library units) whose signature is looked for
  std::vector<std::vector<double>> probes{};
  // +1: only values above the null are possible, -1: only below, 0: both
  int sign = 0;
  // Residual bits it must change; 0: those of its chapter
  unsigned residuals = 0;
  unsigned needs = 0;                           // Need bits
  std::string_view cluster{};                   // letters A..J of look-alikes
  std::vector<std::string_view> confounders{};  // ids
  // ids of effects that this one is, for some of its parameters
  std::vector<std::string_view> contains{};
  // what it contains is no part of it but another cause: both may stand in one set
  bool another_cause = false;
  // ids of what it may be where a joint goes more than `decisions.stop_gives` beyond its position
  std::vector<std::string_view> yielding{};
  std::vector<std::string_view> regimes{};  // where in the motion it shows
  std::string_view signature{};             // in words, for the report
  std::vector<Experiment> experiments{};
  // by parameter; shorter: no key says the rest, and identify leaves the rest alone
  std::vector<SettingChange> settings{};
  std::vector<Identified> identified{};
  std::vector<Tolerance> tolerances{};
  Law law{};
  EffortColumns effort{};                 // where the motion is given and the effort asked
  WholeFigure whole = WholeFigure::none;  // of a base that floats
  std::optional<DriveQuestion> drive{};   // of a robot that stands
  /// Says over which angle the joint's dry friction builds up. Where that is less than
  /// ToleranceSettings::bend (bend_of_dry_friction), it says no more than what it contains.
  bool builds_up = false;
  /// The least that the first parameter can be at this joint or link; empty: its own bound.
  std::function<double(const SimParams&, std::size_t where)> lowest{};
  /// Changes joint (or the link behind joint) `where`; robot scope ignores it. theta.size() ==
  /// parameters.size(). Empty: it shows on no fixed base.
  std::function<void(SimParams&, int where, std::span<const double> theta)> apply{};

  /// The values at which nothing changes, bit for bit, in library units.
  std::vector<double> null() const;
  /// Whether `sanso identify` fits parameter k at a joint with this actuator.
  bool fitted_by_identify(std::size_t k, Actuator actuator) const;
  /// Changes `settings` as parameter k at `value` would; false, and nothing changed, where no key
  /// says it or a key would leave its range.
  bool fold_into(JointSettings& settings, std::size_t k, double value) const;
};

/// Every effect, in the order of the method page.
const std::vector<Effect>& library();
/// nullptr when there is no effect of this id.
const Effect* find_effect(std::string_view id);

/// The effects with columns of a kind, in the order in which they are asked for.
std::vector<const Effect*> effort_effects(EffortKind kind);
/// The effect that a figure of a floating base is. Every figure but `none` is one.
const Effect& effect_of(WholeFigure figure);
/// nullptr: no effect is asked for by this figure of a drive.
const Effect* effect_of(JointFigure figure);
/// effect_of(figure).id
std::string name_of(WholeFigure figure);

/// An effect and one of its tolerances.
struct Tolerated {
  const Effect* effect = nullptr;
  const Tolerance* tolerance = nullptr;
};
/// Every tolerance of the library by its order, those common to all joints last.
std::vector<Tolerated> tolerated_quantities();

/// Documented twins: the names that may rightly stand for an effect. Data in which only one of the
/// two acts need not tell them apart. `name` for what is `truth`: the library lists it among the
/// look-alikes of `truth` (Effect::confounders), or it is `truth` for some of its parameters
/// (Effect::contains). Not the other way round: a special case is no twin of what contains it
/// unless it is listed. Library ids; unknown ones have no twins.
bool documented_twin(std::string_view name, std::string_view truth);

/// How a joint compares with the library's servo; all 1 for the XM430-W350.
struct JointScale {
  double torque = 1.0, speed = 1.0, inertia = 1.0, angle = 1.0, current = 1.0, length = 1.0;
  double reach = 1.0;  // how far from its joint a link's mass lies and others can be put on
  /// What bounds, typical sizes and probes of this unit are multiplied by.
  double of(Unit unit) const;
};

/// Parameter with null, bounds and typical step as they are for this joint.
EffectParameter scaled(const EffectParameter& parameter, const JointScale& scale);
/// Probes of the effect in this joint's sizes; each has a value a parameter, natural units.
std::vector<std::vector<double>> scaled_probes(const Effect& effect, const JointScale& scale);

}  // namespace sanso::diagnose
