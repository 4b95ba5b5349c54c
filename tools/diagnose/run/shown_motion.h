// What the report's robot does: the recorded motion, and simulations of it where they were not
// fitted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/verdict/evidence.h"
#include "tools/diagnose/wholebody/diagnose_whole.h"

namespace sanso::diagnose {

/// One recording, or what is compared of it, in rows of equal distance. A row: the recording's time
/// [s], then each figure's base (position, quaternion w x y z; only of one that floats) and joints
/// (rad, m). Figures: measured, and of simulated motions nominal and patched too.
struct ShownMotion {
  std::string recording;
  double dt = 0.02;  // s
  std::vector<double> numbers;
};
struct ShownMotions {
  std::vector<ShownMotion> motions;
  bool simulated = true;
  std::optional<double> ground;  // height of what a floating base moves over, m
};

/// Held-out recordings with two models' predictions of them: shots of 2 s from the measured state.
struct Simulated {
  Problem problem;
  Eigen::VectorXd nominal, patched;  // whitened errors, stacked
};

/// Without shots when the held-out part is too short.
Simulated simulate_heldout(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                           const Library& library, const HeldoutProof& proof,
                           const Settings& settings);

/// The shots of every recording one after the other, thinned to what an eye can follow, until a
/// report would grow too large.
std::vector<ShownMotion> shown_motions(const Simulated& simulated);
/// Of a base that floats: as recorded, and as both models let it go from the recorded state, for a
/// second at a time, its joints as recorded (wholebody/roll_out.h). As recorded alone where a
/// recording lacks its pose, or the model its shapes. A part that was not recorded rests.
ShownMotions shown_motions(const std::vector<WholeRecording>& recordings, const WholeBody& nominal,
                           const WholeBody& patched);

}  // namespace sanso::diagnose
