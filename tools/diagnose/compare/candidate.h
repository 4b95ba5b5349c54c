// What can be asked of the data: candidate explanations (an effect of the library at a place) and
// nuisances (what a nominal model may be wrong by). A model is a choice of candidates with
// parameters, and values of the nuisances.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "tools/diagnose/compare/problem.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

struct CandidateParameter {
  std::string name, unit;
  double null = 0.0, low = 0.0, high = 0.0;
  // a size at which the effect matters in practice; scale of the fit's coordinate
  double typical = 1.0;
  bool structural = false;  // stays what the probe says; not fitted
  Role role = Role::size;
};

/// Within rounding of the null, in units of the range: a limit that is not switched on is at no
/// bound.
bool at_null(const CandidateParameter& parameter, double value);

struct Candidate {
  std::string effect;               // id of the library
  std::string family;               // "friction", ...
  std::vector<std::string> where;   // joints or links; empty: the whole robot
  std::vector<std::size_t> joints;  // the same, as indices
  std::vector<CandidateParameter> parameters;
  std::vector<std::vector<double>> probes;  // parameter vectors whose signature is looked for
  bool two_sided = true;                    // both signs of a signature are possible
  // judged by scatter (scatter.h), never by one simulated course of events
  bool random = false;
  std::vector<std::string> confounders;  // library ids known to look alike
  // library ids that this effect is, for some of its parameters
  std::vector<std::string> contains;
  std::function<void(SimParams&, const std::vector<double>&)> apply;
  std::string title() const;  // "backlash at l_knee"
};

/// A quantity the nominal model states with finite accuracy: zero-mean Gaussian, standard deviation
/// `tolerance`. It acts as an effect of the library with theta = null + value * direction, so that
/// a calibrated model can be written like any other.
struct Nuisance {
  std::string name;
  std::string effect;  // id of the library
  std::vector<std::size_t> joints;
  std::vector<double> null, direction;
  double tolerance = 1.0;
  std::function<void(SimParams&, int, std::span<const double>)> run;
  /// The effect's parameters at a value in the unit of `tolerance`; 0: the null.
  std::vector<double> theta(double value) const;
  /// The effect with theta(value) at all of `joints`.
  void apply(SimParams& params, double value) const;
};

/// The library on this robot and these channels: every effect at every joint, at mirror pairs and
/// all joints alike, or at the robot; and what cannot be tested, (effect, because). `only` (library
/// ids) restricts the library; empty: all.
struct Placement {
  std::vector<Candidate> candidates;
  std::vector<std::pair<std::string, std::string>> untestable;
};
/// An effect that no place can have is untestable; the reason is the last place's.
Placement place_library(const Comparison& comparison, const std::vector<std::string>& only);

/// What the library says a nominal model may be wrong by (Effect::tolerances): joint by joint in
/// the order of the tolerances, then what is common to all joints.
std::vector<Nuisance> make_nuisances(const Comparison& comparison);

struct Chosen {
  std::size_t candidate = 0;
  std::vector<double> theta;
};

struct Model {
  std::vector<Chosen> effects;
  std::vector<double> nuisance;
  bool has(std::size_t candidate) const;
};

/// Everything that a simulation of a model needs beside the recordings.
struct Library {
  std::vector<Candidate> candidates;
  std::vector<Nuisance> nuisances;
  const Candidate& operator[](std::size_t candidate) const { return candidates[candidate]; }
  const Candidate& operator[](const Chosen& effect) const { return candidates[effect.candidate]; }
  void apply(const Model& model, SimParams& params) const;
};

}  // namespace sanso::diagnose
