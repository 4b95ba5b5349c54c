// Which terms drives and links need, how sure their sizes are, and what else would do as well.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/wholebody/drive_fit.h"

namespace sanso::diagnose {

struct JudgedDriveTerm {
  DriveTerm term;
  std::vector<VerdictParameter> parameters;  // as a person reads them
  double sigma = 0.0, size = 0.0;            // of what is missing, in its surest direction
  double share = 0.0, share_low = 0.0;       // of the left-out error that goes with it
  std::vector<std::string> equally_good;     // other names, with no more numbers
  std::vector<std::string> other_places;     // the same name elsewhere
  std::vector<DriveTerm> rivals;             // of both, what may stand in its place
};

struct DriveChoice {
  std::vector<JudgedDriveTerm> terms;
  std::vector<JudgedDriveTerm>
      spare;              // not surely beyond what a nominal model may be wrong by, and
                          // what is left is adequate without: not in the fit
  bool adequate = true;   // what is left is within what was known beforehand
  double eased = 0.0;     // share of what the nominal model has to be off by that the terms take
  double farthest = 0.0;  // that a figure of the nominal model is off, tolerances
  // RMS left on left-out rows, deviations: by the nominal model as it is, with the terms alone, and
  // with all that a nominal model may be wrong by as well
  double before = 0.0, after = 0.0, least = 0.0;
  Eigen::VectorXd figures, named;  // of the fit with nuisances; of the terms alone
  std::vector<std::string> log;
};

/// The terms that rows need, forward and backward, with the weights that what is left suggests.
/// Needs at least one row (`why_not` empty).
DriveChoice choose_drive_terms(const Asking& asking, const DriveRows& rows);

/// Whether its size is beyond the tolerance, and not by chance.
bool surely_there(const Asking& asking, const JudgedDriveTerm& term);

/// "coulomb_friction at l_knee, r_knee".
std::string in_words(const DriveTerm& term);

}  // namespace sanso::diagnose
