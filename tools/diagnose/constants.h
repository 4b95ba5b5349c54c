// Every figure that a diagnosis depends on, with its reason. What half and double of each does to a
// few cases stands in docs/results/diagnose.md. The gates under "decisions" were added while
// looking at sealed development cases, and kStandInShare while looking at one real recording:
// scores on other data judge them. Not constexpr for one reason: `sanso bench diagnose --constant
// NAME=FACTOR` scales one before anything runs; nothing else writes to them.
#pragma once

namespace sanso::diagnose::constants {

// --- data ----------------------------------------------------------------------------------------
// the horizon an MPC feels (method 3.3, R2); long enough for a servo's lag
inline double kShotSeconds = 0.5;
// slower recordings get longer shots: fewer rows show no shape of motion
inline int kLeastShotRows = 10;
// s: window of the missing-torque residual; between 60 and 240 ms (R3)
inline double kTorqueWindow = 0.1;
// Hz: faster recordings are thinned; joint physics end far below
inline double kFastestRate = 1100.0;
// rows x joints compared in a search; more only narrows intervals
inline int kMaximumRows = 40000;
inline int kMaximumShots = 120;  // shots in a search; the same reason
// of a position's range: below this no simulation is asked to be right
inline double kModelFloor = 2e-4;
// of an electrical or velocity channel's RMS: gain error and filters of such sensors
inline double kSecondaryFloor = 0.05;
// on the smoother's velocity deviation: its motion model is not the robot's
inline double kArrivalInflation = 3.0;

// --- what a nominal model may be wrong by without anything being "missing"
// ------------------------------------------------- Each is both the deviation of the prior and,
// times kToleranceReach, the bound.
inline double kMassTolerance = 0.03;      // relative, weighing and CAD
inline double kLengthTolerance = 0.02;    // relative, centre of mass along the link
inline double kDampingTolerance = 0.05;   // relative, of the actuator's own damping
inline double kFrictionTolerance = 0.05;  // relative, of the dry friction that the model states
// relative, servo stiffness: supply level, rounding in the servo
inline double kGainTolerance = 0.02;
// relative, torque constant and winding resistance (a few kelvin do it)
inline double kMotorTolerance = 0.02;
inline double kZeroTolerance = 0.0015;   // rad: one count of a 12-bit encoder
inline double kLagTolerance = 0.0005;    // s: instants inside a bus cycle are not known better
inline double kArmatureTolerance = 0.1;  // relative, rotor inertia

// of a nuisance in units of its tolerance: 1 / variance of a uniform spread over [-1, 1]
inline double kTolerancePrecision = 3.0;
// of the above: further off, something is missing that wants a name
inline double kToleranceReach = 1.0;

// --- decisions -----------------------------------------------------------------------------------
inline double kFamilyWise = 0.01;  // level of every naming decision (method 3.7)
inline int kNullDraws = 999;       // draws of the family's null law: p resolves to 0.001
// held-out improvement that counts, and the width of "equally good"
inline double kStandardErrors = 2.0;
// of the bootstrap bound above which a held-out gain counts: two deviations
inline double kGainLevel = 0.023;
inline int kGainDraws = 999;  // resamples of that bound: 23 lie below it
// noise levels that a typical effect must make, else "untestable here"
inline double kTestable = 3.0;
// |correlation| above which two effects are one cluster (method 3.6)
inline double kSameSignature = 0.9;
// noise levels RMS over one joint's rows: the faintest severity of method 4; what changes less
inline double kPracticalSize = 0.3;
// (integration step, rounding of goals and duty) is no mismatch that matters
// of the first model's error: smaller effects are not worth a name
inline double kMinimumShare = 0.01;
// of the error energy: a contradicted effect that removes more stays in the model
inline double kStandInShare = 0.5;
// as a description, without being named: better predicted than
// left out
// noise levels: above, what is left has more energy than the noise itself
inline double kAdequate = 1.42;
// cluster representatives fitted fully at every step (method 3.7a)
inline int kRivals = 8;
// more names than this is a different robot, not a missing effect
inline int kMaximumEffects = 6;
// held-out groups when recordings or conditions do not give them
inline int kFolds = 4;
inline int kBootstrap = 199;  // resamples of a confidence interval

// times the median shot's RMS error: from there a shot's weight falls
inline double kShotOutlier = 3.0;

// --- fitting -------------------------------------------------------------------------------------
// s: what its length does to a prediction is corrected, see kFineStep
inline double kSearchStep = 2e-3;
// s: the step at which that is measured; four times finer resolves a first-order error
inline double kFineStep = 5e-4;
inline int kIterations = 7;  // Gauss-Newton steps; most fits stop after 4
// after these a rival far behind the best is not polished further
inline int kFirstIterations = 3;
inline double kPolishShare = 0.3;  // "far behind": by this share of what the best rival removes
// a fit removes at most this many times what the linear screening promises
inline double kLinearReach = 4.0;
inline double kConverged = 1e-3;  // relative decrease of the objective that ends a fit
// fits start this far inside the bounds (rule 2 of the method page)
inline double kInsideBound = 0.05;

}  // namespace sanso::diagnose::constants
