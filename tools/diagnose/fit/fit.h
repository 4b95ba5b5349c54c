// Full fit of a model: all parameters of its effects, the nuisances within their tolerances, the
// shots' starts
// eliminated. Objective   sum over shots rho(r' M r) + sum (nuisance / tolerance)^2 rho(e) = c n
// log(1 + e / (c n)), n the shot's rows: a shot that runs away (a fall through an unstable posture,
// a blow) counts, but does not decide alone.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/compare/start_elimination.h"

namespace sanso::diagnose {

/// What all fits around one model share: start elimination and nuisance derivatives.
struct Surroundings {
  Problem problem;
  const Library* library = nullptr;
  StartElimination starts;
  Eigen::MatrixXd A;        // d r / d (nuisance / tolerance), at `model`
  double shot_scale = 0.0;  // c above, in mean squared whitened error; 0: rho is the identity
  std::optional<std::size_t> left_out = {};            // held-out group that fits do not see
  std::optional<std::size_t> left_out_condition = {};  // a whole condition

  const Settings& settings() const { return problem->settings; }
  bool leaves_out(const Shot& shot) const {
    return shot.group == left_out || shot.condition == left_out_condition;
  }
  /// c from the errors of a reference model: shot_outlier^2 times the median shot's mean square.
  void set_shot_scale(const Eigen::VectorXd& energy_by_shot);
  /// rho of every shot's energy, and its derivative; 0 for shots left out.
  Eigen::VectorXd bounded(const Eigen::VectorXd& energy_by_shot) const;
  Eigen::VectorXd weights(const Eigen::VectorXd& energy_by_shot) const;
};

/// Linearises starts and nuisances at `model`; 2n + nuisances passes.
Surroundings make_surroundings(const Problem& problem, const Library& library, const Model& model);

struct FitResult {
  Model model;
  double objective = 0.0;
  Eigen::VectorXd r;           // prediction error at the optimum
  Eigen::MatrixXd J;           // d r / d (effects' parameters / typical, nuisances / tolerance)
  Eigen::MatrixXd covariance;  // of the same coordinates
  std::vector<char> fixed;     // by the same coordinates: held at a bound, or structural
  int parameters = 0;          // number of effect parameters = leading columns of J
  bool converged = false;
};

/// Gauss-Newton with box projection and step control. `iterations` 0: only evaluates and
/// linearises.
FitResult fit(const Surroundings& around, const Model& start, int iterations);
/// The same, but J and covariance are left empty, which saves the passes of a derivative.
FitResult rough_fit(const Surroundings& around, const Model& start, int iterations);
/// Goes on with a fit, rough or not, in the same surroundings, from its prediction error and the
/// derivatives that it has. `iterations` 0: only gives a rough fit its derivatives.
FitResult resume(const Surroundings& around, FitResult from, int iterations);

/// RMS of a model's position errors in noise levels (or trust floors), starts taken out, shots
/// weighed as in the fits:
/// one that runs away does not decide alone. `expected_scatter`: squares by entry that chance
/// explains; empty: none. An error counts in units of noise and chance together: what chance alone
/// makes large says little about the rest.
double position_error_level(const Surroundings& around, const Eigen::VectorXd& r,
                            const Eigen::VectorXd& expected_scatter);

/// Overdispersion of a projected error by channel: median over shots of mean square x
/// autocorrelation time. Errors that are correlated or larger than the noise carry less information
/// than their number says.
std::vector<double> overdispersion(const Comparison& comparison, const Eigen::VectorXd& projected);

/// Covariance that does not trust the error model. The data count 1 / `inflation` (what is left
/// projects on the other candidates' signatures with this mean square where noise gives 1); and no
/// variance is below that between groups of recordings, or between conditions (jackknife).
/// Coordinates of FitResult::covariance.
Eigen::MatrixXd robust_covariance(const Surroundings& around, const FitResult& fit,
                                  double inflation);

/// Standard deviations of the effect parameters, natural units.
std::vector<double> parameter_sigmas(const FitResult& fit, const Library& library);

/// `model` with its coordinates (those of FitResult::J) moved by `delta`, kept inside the bounds.
Model moved(const Surroundings& around, const Model& model, const Eigen::VectorXd& delta);

/// The `delta` that leads from one model to another of the same effects.
Eigen::VectorXd displacement(const Surroundings& around, const Model& from, const Model& to);

/// How far every coordinate (those of FitResult::J) may move from `model`, down and up: n x 2.
Eigen::MatrixXd room_to_move(const Surroundings& around, const Model& model);

/// What the tolerances add to a model's objective.
double prior_energy(const Surroundings& around, const Model& model);

/// Held-out energy of every shot (rho of r' M r), from a fit without the shot's group: one
/// Gauss-Newton step from the full fit, kept inside the bounds and simulated there, shorter where
/// the other shots do not gain from it: dry friction that sticks a moment later has derivatives
/// that promise any error. Where they gain from no step, a fit without the group is made from the
/// best of the steps: the full fit itself has seen the group, and stands for nothing here.
/// `by_condition`: leaves out whole conditions instead of groups.
Eigen::VectorXd heldout_energy(const Surroundings& around, const FitResult& fit,
                               bool by_condition = false);

/// The same from fits that are really made without each group, within the bounds. The one step
/// above takes a parameter at its bound for known, and goes too far where a group alone determines
/// two parameters that look alike.
Eigen::VectorXd refitted_energy(const Surroundings& around, const FitResult& fit);

/// Measures of a gain that are looked at: each at this share of gain_level.
inline constexpr int kGainMeasures = 3;

/// A gain summed over shots.
struct Paired {
  double total = 0.0;
  double standard_error = 0.0;  // over shots, corrected for dependence between neighbours
  double lower = 0.0;           // bound of `total` at gain_level's share, moving-block bootstrap
};

/// Paired comparison of two models' held-out energies b (before) and a (after) by shot, in three
/// measures. Where friction sticks or slips a few shots hold most of the energy, and a sum of
/// squares has no power; where a small difference is everywhere, it has the most:
///
///   energy    b - a
///   bounded   k log((k + b) / (k + a)),   k = median of (b + a) / 2
///   ranks     sign(b - a) rank(|b - a|) / sum of all ranks   (Wilcoxon 1945)
///
/// Bounded is the fall of the likelihood when every shot's error has a scale of its own: b - a for
/// shots like the others (half of it at k), saturated for those far above. Ranks ask how many
/// shots agree: where one stretch of a recording holds the gain (a sweep through a resonance),
/// resamples without that stretch leave no bound to a sum. Three looks share one level.
///
/// Chance is what differs between the shots of one recording: recordings were chosen, and that a
/// rotor shows in the fast one alone is no doubt about the rotor. Bounds are taken within
/// recordings and added. Standard errors are those over all shots alike: two names are told apart
/// where the recordings agree about them, since what a simulation does wrong differs from one to
/// the other.
struct HeldoutGain {
  Paired energy, bounded, ranks;
  double whole = 0.0;          // bounded gain of a model that leaves nothing: a = 0
  double concentration = 0.0;  // share of the energy removed that the three best shots give

  /// Squared noise levels on held-out shots.
  double removed() const { return energy.total; }
  bool beyond_chance() const {
    return energy.lower > 0.0 || bounded.lower > 0.0 || ranks.lower > 0.0;
  }
  /// The gain in standard errors, less a unit of log-likelihood: the more certain measure's.
  double certainty() const;
};
/// `before`, `after`: energies by shot of the comparison, without and with what is judged.
HeldoutGain compare(const Comparison& comparison, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after);
/// The same for shots of one recording, or where parts were left out that hold recordings as a
/// whole: then what differs between recordings is chance too.
HeldoutGain compare(const DecisionSettings& settings, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after);
/// Median over shots of an energy, the unit k for several models compared at once; never 0.
double typical_energy(const Eigen::VectorXd& energy);
/// k log((k + e) / k) summed over shots: the measure above against a model that leaves nothing.
double bounded_energy(const Eigen::VectorXd& energy, double unit);
/// The same for an effect that acts only now and then. `occurrence`: by shot, which of its
/// occurrences the shot belongs to, if any. Bound and error are those over occurrences and over
/// the other shots, added: resampling all shots alike would ask whether the effect acts, not
/// whether the name explains it.
HeldoutGain compare(const Comparison& comparison, const Eigen::VectorXd& before,
                    const Eigen::VectorXd& after,
                    const std::vector<std::optional<std::size_t>>& occurrence);

}  // namespace sanso::diagnose
