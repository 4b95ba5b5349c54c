// Which terms drives and links need, how sure their sizes are, and what else would do as well.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/wholebody/drive_fit.h"

namespace sanso::diagnose {

struct JudgedDriveTerm {
  DriveTerm term;
  std::vector<VerdictParameter> parameters;  // as a person reads them
  double sigma = 0.0, size = 0.0;            // of what is missing, in its own direction
  double share = 0.0, share_low = 0.0;       // of the left-out error that goes with it
  std::vector<std::string> equally_good;     // other names, with no more numbers
  std::vector<std::string> other_places;     // the same name elsewhere
};

struct DriveChoice {
  std::vector<JudgedDriveTerm> terms;
  bool adequate = true;              // what is left is within what was known beforehand
  double before = 0.0, after = 0.0;  // RMS left on left-out rows, deviations
  Eigen::VectorXd figures;           // of the fit, nuisances too
  std::vector<std::string> log;
};

/// The terms that rows need, forward and backward, with the weights that what is left suggests.
/// Needs at least one row (`why_not` empty).
DriveChoice choose_drive_terms(const Asking& asking, const DriveRows& rows);

struct DriveBalance {
  DriveRows rows;
  DriveChoice choice;  // nothing where rows say why not
};
/// Rows and the terms they need; both again where those scale the torques that rows were made with.
DriveBalance balance_drives(const Asking& asking);

/// "coulomb_friction at l_knee, r_knee".
std::string in_words(const DriveTerm& term);

}  // namespace sanso::diagnose
