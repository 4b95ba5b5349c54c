// Every figure that a diagnosis depends on, with its reason. What half and double of each does to a few cases stands in
// docs/results/diagnose.md. The gates under "decisions" were added while looking at sealed
// development cases, and kStandInShare while looking at one real recording: scores on other data judge them. Not
// constexpr for one reason: `sanso bench diagnose --constant NAME=FACTOR` scales one before anything runs; nothing else
// writes to them.
#pragma once

namespace sanso::diagnose::constants {

// --- data
// ---------------------------------------------------------------------------------------------------------------
inline double kShotSeconds = 0.5;     // the horizon an MPC feels (method 3.3, R2); long enough for a servo's lag
inline int kLeastShotRows = 10;       // slower recordings get longer shots: fewer rows show no shape of motion
inline double kTorqueWindow = 0.1;    // s: window of the missing-torque residual; between 60 and 240 ms (R3)
inline double kFastestRate = 1100.0;  // Hz: faster recordings are thinned; joint physics end far below
inline int kMaximumRows = 40000;      // rows x joints compared in a search; more only narrows intervals
inline int kMaximumShots = 120;       // shots in a search; the same reason
inline double kModelFloor = 2e-4;     // of a position's range: below this no simulation is asked to be right
inline double kSecondaryFloor =
    0.05;  // of an electrical or velocity channel's RMS: gain error and filters of such sensors
inline double kArrivalInflation = 3.0;  // on the smoother's velocity deviation: its motion model is not the robot's

// --- what a nominal model may be wrong by without anything being "missing"
// ------------------------------------------------- Each is both the deviation of the prior and, times kToleranceReach,
// the bound.
inline double kMassTolerance = 0.03;      // relative, weighing and CAD
inline double kLengthTolerance = 0.02;    // relative, centre of mass along the link
inline double kDampingTolerance = 0.05;   // relative, of the actuator's own damping
inline double kFrictionTolerance = 0.05;  // relative, of the dry friction that the model states
inline double kGainTolerance = 0.02;      // relative, servo stiffness: supply level, rounding in the servo
inline double kMotorTolerance = 0.02;     // relative, torque constant and winding resistance (a few kelvin do it)
inline double kZeroTolerance = 0.0015;    // rad: one count of a 12-bit encoder
inline double kLagTolerance = 0.0005;     // s: instants inside a bus cycle are not known better
inline double kArmatureTolerance = 0.1;   // relative, rotor inertia

inline double kTolerancePrecision =
    3.0;  // of a nuisance in units of its tolerance: 1 / variance of a uniform spread over [-1, 1]
inline double kToleranceReach = 1.0;  // of the above: further off, something is missing that wants a name

// --- decisions
// ------------------------------------------------------------------------------------------------------------
inline double kFamilyWise = 0.01;     // level of every naming decision (method 3.7)
inline int kNullDraws = 999;          // draws of the family's null law: p resolves to 0.001
inline double kStandardErrors = 2.0;  // held-out improvement that counts, and the width of "equally good"
inline double kGainLevel = 0.023;     // of the bootstrap bound above which a held-out gain counts: two deviations
inline int kGainDraws = 999;          // resamples of that bound: 23 lie below it
inline double kTestable = 3.0;        // noise levels that a typical effect must make, else "untestable here"
inline double kSameSignature = 0.9;   // |correlation| above which two effects are one cluster (method 3.6)
inline double kPracticalSize =
    0.3;  // noise levels RMS over one joint's rows: the faintest severity of method 4; what changes less
          // (integration step, rounding of goals and duty) is no mismatch that matters
inline double kMinimumShare = 0.01;  // of the first model's error: smaller effects are not worth a name
inline double kStandInShare = 0.5;   // of the error energy: a contradicted effect that removes more stays in the model
                                     // as a description, without being named: better predicted than left out
inline double kAdequate = 1.42;      // noise levels: above, what is left has more energy than the noise itself
inline int kRivals = 8;              // cluster representatives fitted fully at every step (method 3.7a)
inline int kMaximumEffects = 6;      // more names than this is a different robot, not a missing effect
inline int kFolds = 4;               // held-out groups when recordings or conditions do not give them
inline int kBootstrap = 199;         // resamples of a confidence interval

inline double kShotOutlier = 3.0;  // times the median shot's RMS error: from there a shot's weight falls

// --- fitting
// --------------------------------------------------------------------------------------------------------------
inline double kSearchStep = 2e-3;  // s: what its length does to a prediction is corrected, see kFineStep
inline double kFineStep = 5e-4;  // s: the step at which that is measured; four times finer resolves a first-order error
inline int kIterations = 7;      // Gauss-Newton steps; most fits stop after 4
inline int kFirstIterations = 3;    // after these a rival far behind the best is not polished further
inline double kPolishShare = 0.3;   // "far behind": by this share of what the best rival removes
inline double kLinearReach = 4.0;   // a fit removes at most this many times what the linear screening promises
inline double kConverged = 1e-3;    // relative decrease of the objective that ends a fit
inline double kInsideBound = 0.05;  // fits start this far inside the bounds (rule 2 of the method page)

}  // namespace sanso::diagnose::constants
