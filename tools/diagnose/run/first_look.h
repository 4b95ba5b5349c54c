// The linear first look that simpler methods would stop at, for those that are compared with this
// one.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/fit/screen.h"
#include "tools/diagnose/settings.h"

namespace sanso::diagnose {

/// One entry a probe of a candidate.
struct FirstLook {
  std::vector<std::string> effect;
  std::vector<Family> family;
  std::vector<double> z;            // matched-filter score of the probe
  std::vector<double> correlation;  // probes x probes, of the projected signatures
  // |z| that the family's maximum exceeds by chance once in a hundred
  double critical = 0.0;
  /// Inner products of [nuisances / tolerance | probes | error] by held-out group, starts
  /// eliminated; empty unless DiagnoseOptions::first_look_by_group.
  std::vector<Eigen::MatrixXd> by_group;
  Eigen::Index nuisances = 0;
  double nuisance_precision = 0.0;  // prior of the nuisances in these units
};

/// What a screening saw, entry by entry in the order of its probes; `tolerances` says how precisely
/// the nuisances are known.
FirstLook first_look(const Library& library, const Screening& first,
                     const ToleranceSettings& tolerances);

}  // namespace sanso::diagnose
