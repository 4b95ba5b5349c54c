// `sanso diagnose`: from a model folder and recordings to a verdict, a patched model and everything
// the report shows.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/explain/select.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/verdict/location_map.h"
#include "tools/diagnose/verdict/predictability.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

struct DiagnoseOptions {
  std::string model;                    // model folder
  std::vector<std::string> recordings;  // files
  // folder for verdict.json, report.html, model/; empty: nothing is written
  std::string out;
  std::vector<std::string> effects;  // restrict the library to these ids; empty: all
  std::vector<std::string> without;  // leave these ids out of the library (leave-one-out proofs)
  bool json = false;                 // print verdict.json instead of the summary
  bool quiet = false;                // no progress lines
  unsigned long seed = 1;
  Settings settings;
  // fills FirstLook::by_group, for methods that are compared with this one
  bool first_look_by_group = false;
};

/// One roll-out on held-out data for the report: measured, nominal, patched position of a joint.
struct RollOut {
  std::string recording, joint;
  std::vector<double> t, measured, nominal, patched;
  double noise = 0.0;
};

/// The linear first look that simpler methods would stop at: one entry a probe of a candidate.
struct FirstLook {
  std::vector<std::string> effect, family;
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

/// All that was found out; the verdict is what counts, the rest feeds the report.
struct Diagnosis {
  Verdict verdict;
  std::optional<ModelFolder> patched;
  LocationMap before, after;
  std::vector<std::string> regimes, joints;
  std::vector<char> slides;                                          // by joint, not 0: prismatic
  std::vector<std::vector<ShapeCurve>> curves_before, curves_after;  // by joint of `shown_joints`
  std::vector<int> shown_joints;
  std::vector<RollOut> roll_outs;
  std::vector<std::string> log;
  FirstLook first_look;
};

using Progress = std::function<void(const std::string&)>;

/// The whole method. Bad input gives a verdict with status REFUSED; nothing is thrown but
/// Interrupted, and std::invalid_argument for settings outside their range.
Diagnosis diagnose(const DiagnoseOptions& options, const Progress& progress);

/// The command: runs, prints, writes `out`. Exit code 0 no mismatch, 1 mismatch found, 2 refused.
int run_diagnose(const DiagnoseOptions& options);

}  // namespace sanso::diagnose
