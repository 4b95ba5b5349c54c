// Every figure that a diagnosis depends on, declared once: name, unit, default, range, reason. The
// settings page, the range check and the bench that halves and doubles walk the same visit(). What
// half and double of each does to a few cases stands in docs/results/diagnose.md. The gates among
// the decisions were added while looking at sealed development cases, and stand_in_share while
// looking at one real recording: scores on other data judge them.
#pragma once

#include "tools/diagnose/settings_of_data.h"
#include "tools/diagnose/settings_of_search.h"
#include "tools/diagnose/settings_of_simulation.h"
#include "tools/diagnose/settings_of_whole.h"

namespace sanso::diagnose {

/// What a nominal model may be wrong by without anything being missing: the deviation of the prior
/// and, times `reach`, the bound.
struct ToleranceSettings {
  double mass = 0.03;
  double length = 0.02;
  double damping = 0.05;
  double friction = 0.05;
  double gain = 0.02;
  double motor = 0.02;
  double zero = 0.0015;
  double lag = 0.0005;
  double poll = 0.0025;
  double armature = 0.125;
  double creep = 0.05;
  double bend = 0.00077;
  double precision = 3.0;
  double reach = 1.0;
  template <class Field>
  void visit(Field&& field) {
    field("mass", mass, "relative", 0.0001, 0.5, "weighing and CAD");
    field("length", length, "relative", 0.0001, 0.5, "centre of mass along the link");
    field("damping", damping, "relative", 0.0001, 0.9, "of the actuator's own damping");
    field("friction", friction, "relative", 0.0001, 0.9,
          "of the dry friction that the model states");
    field("gain", gain, "relative", 0.0001, 0.5,
          "servo stiffness: supply level, rounding in the servo");
    field("motor", motor, "relative", 0.0001, 0.5,
          "torque constant and winding resistance (a few kelvin do it)");
    field("zero", zero, "rad", 1e-06, 0.1, "one count of a 12-bit encoder");
    field("lag", lag, "s", 1e-06, 0.05, "instants inside a bus cycle are not known better");
    field("poll", poll, "s", 0.0, 0.1,
          "a delay of commands up to it may be a wait for a servo that looks now and then");
    field("armature", armature, "relative", 0.0001, 0.9,
          "rotor inertia: a tenth by the data sheet, and what steps of time make of it");
    field("creep", creep, "rad/s", 1e-06, 1.0,
          "below it laws of dry friction differ that are alike above: bristles, regularised signs");
    field("bend", bend, "rad", 1e-07, 0.1,
          "over which dry friction builds up, in the mean: half a count of a 12-bit encoder");
    field("precision", precision, "1 / tolerance^2", 0.01, 100.0,
          "of a nuisance: 1 / variance of a uniform spread over [-1, 1]");
    field("reach", reach, "tolerances", 0.1, 10.0,
          "further off, something is missing that wants a name");
  }
};

/// What counts: levels, widths and sizes by which names are given or refused.
struct DecisionSettings {
  double family_wise = 0.01;
  int null_draws = 999;
  double standard_errors = 2.0;
  double gain_level = 0.023;
  int gain_draws = 999;
  int fewest_shots = 6;
  double testable = 3.0;
  double same_signature = 0.9;
  double practical_size = 0.3;
  double minimum_share = 0.01;
  double stand_in_share = 0.5;
  double mostly_agree = 0.5;
  double adequate = 1.42;
  int rivals = 8;
  int rivals_beside = 24;
  int pairs = 4;
  int pairs_of_one = 2;
  double one_signature = 0.005;
  double tied_drives = 2.0;
  double same_robot = 0.25;
  double same_law = 0.015;
  double interval_stretch = 1.6;
  double much_left = 0.18;
  double rest_of_law = 0.02;
  double rest_of_joint = 0.05;
  double sure_size = 2.0;
  double only_there = 10.0;
  double stop_gives = 0.1;
  int disagreeing_groups = 6;
  int maximum_effects = 6;
  int rounds = 3;
  int folds = 4;
  int bootstrap = 199;
  double shot_outlier = 3.0;
  int tolerance_draws = 12;
  double nearly_strongest = 0.8;
  double unseen = 0.1;
  double known_first = 0.5;
  double promised = 5.0;
  double promised_share = 0.02;
  double happened_least = 0.5;
  double happened_most = 2.0;
  double predictable = 0.1;
  double missing_effort = 1.5;
  template <class Field>
  void visit(Field&& field) {
    visit_search(field);
    visit_names(field);
  }

 private:
  void visit_search(auto& field) {
    field("family_wise", family_wise, "probability", 1e-06, 0.5, "level of every naming decision");
    field("null_draws", null_draws, "draws", 19, 1000000,
          "of the family's null law: p resolves to 0.001");
    field("standard_errors", standard_errors, "standard errors", 0.1, 20.0,
          "held-out improvement that counts, and the width of equally good");
    field("gain_level", gain_level, "probability", 0.0001, 0.5,
          "of the bootstrap bound above which a held-out gain counts: two deviations");
    field("gain_draws", gain_draws, "draws", 19, 1000000, "of that bound: 23 lie below it");
    field("fewest_shots", fewest_shots, "shots", 2, 1000,
          "of a recording that is resampled apart: fewer cannot tell how much they scatter");
    field("testable", testable, "noise levels", 0.1, 100.0,
          "that a typical effect must make, else it is untestable here");
    field("same_signature", same_signature, "correlation", 0.1, 2.0, "above: one cluster");
    field("practical_size", practical_size, "noise levels", 0.01, 10.0,
          "RMS over one joint's rows; less (integration step, rounding of goals) does not matter");
    field("minimum_share", minimum_share, "share", 1e-06, 0.5,
          "of the first model's error: smaller effects are not worth a name");
    field("stand_in_share", stand_in_share, "share", 0.01, 1.0,
          "of the error energy: a contradicted effect that removes more stays, as a description");
    field("mostly_agree", mostly_agree, "share of ranks", 0.01, 1.0,
          "of the shots that gain, at least: from a name whose interval may contain the null");
    field("adequate", adequate, "noise levels", 0.1, 20.0,
          "above, what is left has more energy than the noise itself");
    field("rivals", rivals, "candidates", 1, 1000, "of clusters, fitted fully at every step");
    field("rivals_beside", rivals_beside, "candidates times names", 1, 10000,
          "at most: a fit moves all names, and what comes after the third seldom is one");
    field("pairs", pairs, "pairs", 0, 1000,
          "of effects fitted together where none passes alone; each costs as much as two rivals");
    field("pairs_of_one", pairs_of_one, "pairs", 1, 1000,
          "in which one effect stands: others want to be heard");
    field("one_signature", one_signature, "1 - correlation", 1e-6, 0.5,
          "signatures of a pair that are more alike cannot be told apart by the screening");
    field("tied_drives", tied_drives, "factor", 1.0, 1000.0,
          "in torque between joints that share one number: one for unlike drives is nobody's");
  }
  void visit_names(auto& field) {
    field("same_robot", same_robot, "share", 0.001, 2.0,
          "of an effect's size: recordings that differ by less are one robot on two days");
    field("same_law", same_law, "share", 1e-06, 0.5,
          "of a figure's size: two laws of one name, both fitted, differ by as much (deviation)");
    field("interval_stretch", interval_stretch, "factor", 0.5, 5.0,
          "on intervals of figures: seven of eight in fresh sealed cases hold then (docs/results)");
    field("much_left", much_left, "share", 0.0, 10.0,
          "of the error beyond noise: names that leave more, above `adequate`, are not sure");
    field("rest_of_law", rest_of_law, "share", 0.0, 1.0,
          "of what a name removes: a rival behind by less is as good, for its law may be off by a "
          "seventh");
    field("rest_of_joint", rest_of_joint, "share", 0.0, 1.0,
          "of what a name removes: another at its joint that removes less may be what its law is "
          "off by (a fifth)");
    field("sure_size", sure_size, "factor", 1.0, 100.0,
          "on the interval of a name beside one that removes more: it has to leave the null");
    field("only_there", only_there, "variance ratio", 1.0, 1e6,
          "of a number that other conditions do not tell: left out, they keep it");
    field("stop_gives", stop_gives, "rad or m", 0.0, 10.0,
          "beyond its position: a stop that lets a joint further may be a cord that becomes taut");
    field("disagreeing_groups", disagreeing_groups, "groups", 2, 100,
          "of recordings asked one by one at most: each takes a fit, more say no more");
    field("maximum_effects", maximum_effects, "effects", 1, 100, "more are a different robot");
    field("rounds", rounds, "rounds", 0, 100, "of further steps at most, after an exchange");
    field("folds", folds, "groups", 1, 100, "held out, where recordings do not give them");
    field("bootstrap", bootstrap, "draws", 19, 100000, "resamples of a confidence interval");
    field("shot_outlier", shot_outlier, "factor", 0.5, 100.0,
          "times the median shot's RMS error: from there a shot's weight falls");
    field("tolerance_draws", tolerance_draws, "draws", 1, 1000,
          "of a tolerated model, whose largest scatter is no event: one shot in thirteen is above");
    field("nearly_strongest", nearly_strongest, "share", 0.1, 2.0,
          "of its cluster's strongest score: the simplest member that has it speaks for all");
    field("unseen", unseen, "share", 0.0001, 1.0,
          "of the variance that a number keeps which moves no row: above it the fit chose none");
    field("known_first", known_first, "correlation", 0.0, 2.0, "more for a documented look-alike");
    field("promised", promised, "noise levels", 0.5, 100.0,
          "that an effect promises to change a residual by: from here on it is held to it");
    field("promised_share", promised_share, "share", 0.0001, 0.5,
          "of all that it promises, the least of one residual that counts");
    field("happened_least", happened_least, "share", 0.05, 1.0,
          "of what was promised: surely less contradicts a name");
    field("happened_most", happened_most, "factor", 1.0, 20.0,
          "times what was promised: surely more contradicts a name");
    field("predictable", predictable, "share", 0.001, 0.9,
          "of the missing effort, from the joint's state: less says nothing");
    field("missing_effort", missing_effort, "noise levels", 0.1, 100.0, "of an effort missing");
  }
};

/// What is asked of what stays without a name, and of the next experiment.
struct RemainsSettings {
  int fourier_features = 40;
  int experiment_shots = 16;
  double horizon = 0.5;
  double matters = 0.0;
  double most = 0.75;
  int least_samples = 40;
  int blocks = 5;
  int formula_terms = 4;
  double formula_share = 0.02;
  int effort_samples = 600;
  template <class Field>
  void visit(Field&& field) {
    field("fourier_features", fourier_features, "features", 1, 10000,
          "random ones of the state that predict the missing torque");
    field("experiment_shots", experiment_shots, "shots", 1, 10000,
          "suffice to compare entries of the menu of experiments");
    field("horizon", horizon, "s", 0.01, 60.0, "how far ahead the user predicts");
    field("matters", matters, "rad, m, N m, N", 0.0, 1e6, "smaller errors there are good enough");
    field("most", most, "share", 0.1, 2.0, "of the squared error explained: the RMS is halved");
    field("least_samples", least_samples, "samples", 4, 100000,
          "of a joint's missing torque; with fewer nothing is said of it");
    field("blocks", blocks, "blocks", 2, 100,
          "in time, each predicted by what was learned from the others");
    field("formula_terms", formula_terms, "terms", 1, 20, "of a formula that a person can read");
    field("formula_share", formula_share, "share", 0.0001, 0.5,
          "of the squared missing torque that a term has to explain to be worth reading");
    field("effort_samples", effort_samples, "samples", 40, 1000000,
          "of a joint's missing effort: enough for the random features, resampled in seconds");
  }
};

/// The torque side: what effort is missing at the recorded motion.
struct EffortSettings {
  double window = 0.03;
  double block = 0.25;
  double standing = 0.02;
  double standing_sigmas = 4.0;
  double judged_share = 0.4;
  double outlier = 2.5;
  int rounds = 4;
  int highest_order = 100;
  int ripples = 12;
  int maximum_terms = 60;
  double gain_share = 0.05;
  double ends = 0.05;
  int blocks = 120;
  double nearly = 0.1;
  double beyond = 1.5;
  int pieces = 4;
  template <class Field>
  void visit(Field&& field) {
    field("window", window, "s", 0.001, 1.0,
          "over which effort and motion are averaged; far shorter than a reversal of speed");
    field("block", block, "s", 0.01, 60.0,
          "resampled and left out as a whole: longer than errors of the effort hang together");
    field("standing", standing, "share of the fast speed", 0.0, 0.5,
          "below it a joint is about to stand, and its friction may have any value");
    field("standing_sigmas", standing_sigmas, "deviations", 0.0, 100.0,
          "of the smoothed velocity: below, the direction of motion is not known");
    field("judged_share", judged_share, "share", 0.1, 0.9,
          "of a single recording, its end; terms are chosen and fitted on the rest");
    field("outlier", outlier, "deviations", 0.5, 100.0,
          "a row's weight falls from here: impacts and reversals inside a window");
    field("rounds", rounds, "rounds", 1, 100,
          "of choosing with new weights; most settle after two");
    field("highest_order", highest_order, "periods in a turn", 1, 400,
          "of a ripple of the angle: poles and slots of a motor at the joint");
    field("ripples", ripples, "orders", 0, 100, "named at most at one joint");
    field("maximum_terms", maximum_terms, "terms", 1, 500,
          "of all joints: more is a table, not a cause");
    field("gain_share", gain_share, "share", 0.0, 1.0,
          "of the effort that the links' known weight and inertia must explain to tell a gain");
    field("ends", ends, "s", 0.0, 5.0,
          "left out: the smoother knows acceleration from one side only there");
    field("blocks", blocks, "blocks", 8, 10000, "at most: more sharpen no interval");
    field("nearly", nearly, "share", 0.0, 0.9,
          "of the best gain that a term of the same joint, no link's, may fall behind");
    field("beyond", beyond, "factor", 0.5, 100.0,
          "times the fastest motion that was fitted: beyond, nothing is judged");
    field("pieces", pieces, "pieces", 2, 100,
          "of a recording left out in turn: how well it tells its own value of a term");
  }
};

/// Of the motion that an OP3 should make next.
struct NextSettings {
  int times = 2;
  double fastest = 0.4;
  double varied = 0.25;
  double better = 0.1;
  double least = 1e-3;
  template <class Field>
  void visit(Field&& field) {
    field("times", times, "times", 1, 100,
          "that the poses come again: what is fitted to one is tried on the next");
    field("fastest", fastest, "s", 0.05, 10.0,
          "from pose to pose at least: no faster than the shipped motions go");
    field("varied", varied, "share", 0.01, 10.0,
          "by which a figure of the best motion is made larger and smaller");
    field("better", better, "share", 0.0001, 100.0,
          "that a variation has to tell more a second, or the search ends");
    field("least", least, "nats/s", 1e-9, 1000.0,
          "that anything recorded next has to tell: with less it is an hour");
  }
};

struct Settings {
  GateSettings gate;
  DataSettings data;
  SmootherSettings smoother;
  LibrarySettings library;
  SimulationSettings simulation;
  ToleranceSettings tolerances;
  DecisionSettings decisions;
  FittingSettings fitting;
  ChanceSettings chance;
  RegimeSettings regimes;
  RemainsSettings remains;
  EffortSettings effort;
  BaseSettings base;
  WholeSettings whole;
  StanceSettings stance;
  NextSettings next;
  /// Calls section(name, struct) for every group, in the order of the settings page.
  template <class Section>
  void visit(Section&& section) {
    section("gate", gate);
    section("data", data);
    section("smoother", smoother);
    section("library", library);
    section("simulation", simulation);
    section("tolerances", tolerances);
    section("decisions", decisions);
    section("fitting", fitting);
    section("chance", chance);
    section("regimes", regimes);
    section("remains", remains);
    section("effort", effort);
    section("base", base);
    section("whole", whole);
    section("stance", stance);
    section("next", next);
  }
};

}  // namespace sanso::diagnose
