// What may be missing in drives and links, as sums of the columns of drive_rows.h: a name, its
// places, its numbers; and what a nominal model may be wrong by.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/wholebody/drive_rows.h"

namespace sanso::diagnose {

/// A name at its places. Coefficients x (unknown) become figures: columns * x; and numbers that a
/// person reads: `nothing` + x, a place divided by the mass.
struct DriveTerm {
  std::string effect;
  Family family{};
  std::vector<std::string> where;
  std::vector<std::string> parameters, units;
  std::vector<double> low, high;  // bounds of x
  double nothing = 0.0;           // the parameter where nothing is missing
  double tolerance = 0.0;         // of x: within it nothing is missing
  double mass = 0.0;              // kg: first moments over it are lengths (0: numbers are x)
  double steps = 0.0;             // what lies between two values that the rows can tell apart
  bool inverse = false;           // x = 1 - 1 / number: a scale of what the motion needs
  bool carried = false;           // a payload: its own mass is the first number
  V3 centre = V3::Zero();         // of the link: where a payload's moments count from, m
  Eigen::MatrixXd columns;        // figures x numbers
  Eigen::Index size() const { return static_cast<Eigen::Index>(parameters.size()); }
};

/// Drives by kind, by leg, by mirrored pair and one by one; links one by one.
std::vector<DriveTerm> drive_terms(const Asking& asking, const DriveRows& rows);

/// Always in the fit, drawn to zero: 1 / variance of each.
struct DriveNuisances {
  Eigen::MatrixXd columns;
  Eigen::VectorXd precision;
  std::vector<std::string> names;  // as a person reads them
};
/// By joint zero, gain, damping, dry friction, friction per load, rotor (torque constant where a
/// current is recorded); the delay of all goals; masses and centres of links; what of the
/// damping is electrical; what sensors read. Those that may not be off at all are left out.
DriveNuisances drive_nuisances(const Asking& asking, const DriveRows& rows);

}  // namespace sanso::diagnose
