// Every figure that a diagnosis depends on, with its reason. None was tuned on cases; docs/results/diagnose.md shows what
// half and double of each does to the scores.
#pragma once

namespace sanso::diagnose::constants {

// --- data ---------------------------------------------------------------------------------------------------------------
inline constexpr double kShotSeconds = 0.5;       // the horizon an MPC feels (method 3.3, R2); long enough for a servo's lag
inline constexpr int kLeastShotRows = 10;         // slower recordings get longer shots: fewer rows show no shape of motion
inline constexpr double kTorqueWindow = 0.1;      // s: window of the missing-torque residual; between 60 and 240 ms (R3)
inline constexpr double kFastestRate = 1100.0;    // Hz: faster recordings are thinned; joint physics end far below
inline constexpr int kMaximumRows = 40000;        // rows x joints compared in a search; more only narrows intervals
inline constexpr int kMaximumShots = 120;         // shots in a search; the same reason
inline constexpr double kModelFloor = 2e-4;       // of a position's range: below this no simulation is asked to be right
inline constexpr double kSecondaryFloor = 0.05;   // of an electrical or velocity channel's RMS: gain error and filters of such sensors
inline constexpr double kArrivalInflation = 3.0;  // on the smoother's velocity deviation: its motion model is not the robot's

// --- what a nominal model may be wrong by without anything being "missing" -------------------------------------------------
// Each is both the deviation of the prior and, times kToleranceReach, the bound.
inline constexpr double kMassTolerance = 0.03;    // relative, weighing and CAD
inline constexpr double kLengthTolerance = 0.02;  // relative, centre of mass along the link
inline constexpr double kDampingTolerance = 0.05; // relative, of the actuator's own damping
inline constexpr double kFrictionTolerance = 0.05; // relative, of the dry friction that the model states
inline constexpr double kGainTolerance = 0.02;    // relative, servo stiffness: supply level, rounding in the servo
inline constexpr double kMotorTolerance = 0.02;   // relative, torque constant and winding resistance (a few kelvin do it)
inline constexpr double kZeroTolerance = 0.0015;  // rad: one count of a 12-bit encoder
inline constexpr double kLagTolerance = 0.0005;   // s: instants inside a bus cycle are not known better
inline constexpr double kArmatureTolerance = 0.1; // relative, rotor inertia

inline constexpr double kToleranceReach = 1.0;    // of the above: further off, something is missing that wants a name

// --- decisions ------------------------------------------------------------------------------------------------------------
inline constexpr double kFamilyWise = 0.01;       // level of every naming decision (method 3.7)
inline constexpr int kNullDraws = 999;            // draws of the family's null law: p resolves to 0.001
inline constexpr double kStandardErrors = 2.0;    // held-out improvement that counts, and the width of "equally good"
inline constexpr double kTestable = 3.0;          // noise levels that a typical effect must make, else "untestable here"
inline constexpr double kSameSignature = 0.9;     // |correlation| above which two effects are one cluster (method 3.6)
inline constexpr double kMinimumShare = 0.01;     // of the first model's error: smaller effects are not worth a name
inline constexpr double kNamedShare = 0.8;        // of the excess error a complete explanation removes; below: also "unnamed"
inline constexpr double kAdequate = 1.42;         // noise levels: above, what is left has more energy than the noise itself
inline constexpr int kRivals = 8;                 // cluster representatives fitted fully at every step (method 3.7a)
inline constexpr int kMaximumEffects = 6;         // more names than this is a different robot, not a missing effect
inline constexpr int kFolds = 4;                  // held-out groups when recordings or conditions do not give them
inline constexpr int kBootstrap = 199;            // resamples of a confidence interval

inline constexpr double kShotOutlier = 3.0;       // times the median shot's RMS error: from there a shot's weight falls

// --- fitting --------------------------------------------------------------------------------------------------------------
inline constexpr double kSearchStep = 2e-3;       // s: at 1 ms errors differ by a tenth of an encoder count
inline constexpr int kIterations = 7;             // Gauss-Newton steps; most fits stop after 4
inline constexpr int kFirstIterations = 3;        // after these a rival far behind the best is not polished further
inline constexpr double kPolishShare = 0.3;       // "far behind": by this share of what the best rival removes
inline constexpr double kLinearReach = 4.0;       // a fit removes at most this many times what the linear screening promises
inline constexpr double kConverged = 1e-3;        // relative decrease of the objective that ends a fit
inline constexpr double kInsideBound = 0.05;      // fits start this far inside the bounds (rule 2 of the method page)

}  // namespace sanso::diagnose::constants
