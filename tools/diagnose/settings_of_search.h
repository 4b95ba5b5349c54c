// How the search for names goes: how finely models are fitted, how chance is judged, when a joint
// is said to reverse or to stand.
#pragma once

namespace sanso::diagnose {

/// How far and how finely a fit goes.
struct FittingSettings {
  double search_step = 0.002;
  double fine_step = 0.0005;
  int iterations = 7;
  int first_iterations = 3;
  double polish_share = 0.3;
  double linear_reach = 4.0;
  double converged = 0.001;
  double inside_bound = 0.05;
  double derivative_step = 0.03;
  int order_steps = 16;
  int places = 14;
  int halvings = 5;
  double event_resolution = 0.0078125;
  double event_reach = 2.5;
  int nuisance_sweeps = 300;
  int pursuit = 5;
  int identify_rounds = 6;
  double identify_settled = 0.1;
  int attempts = 6;
  int thinned_from = 60;
  int thinned_every = 3;
  double recalled = 0.5;
  int steps_anew = 3;
  int steps_without = 4;
  double farthest_start = 3.0;
  double beyond_orders = 1.5;
  template <class Field>
  void visit(Field&& field) {
    field(
        "search_step", search_step, "s", 1e-05, 0.05,
        "step of the integrator; what its length does to a prediction is corrected, see fine_step");
    field("fine_step", fine_step, "s", 1e-06, 0.05,
          "the step at which that is measured; four times finer resolves a first-order error");
    field("iterations", iterations, "steps", 1, 1000, "Gauss-Newton steps; most fits stop after 4");
    field("first_iterations", first_iterations, "steps", 1, 1000,
          "after these a rival far behind the best is not polished further");
    field("polish_share", polish_share, "share", 0.01, 10.0,
          "far behind: by this share of what the best rival removes");
    field("linear_reach", linear_reach, "factor", 0.5, 100.0,
          "a fit removes at most this many times what the linear screening promises");
    field("converged", converged, "relative", 1e-09, 0.5,
          "decrease of the objective that ends a fit");
    field("inside_bound", inside_bound, "share of the range", 0.0001, 0.4,
          "fits start this far inside the bounds");
    field("derivative_step", derivative_step, "typical sizes", 0.0001, 0.5,
          "small against curvature, large against kinks of the integrator's step");
    field("order_steps", order_steps, "steps", 1, 1000, "tried at most between two probed orders");
    field("places", places, "places", 1, 1000,
          "a position is tried on a grid first; off by half a step it still explains most");
    field("halvings", halvings, "halvings", 1, 30, "of a step of that grid, to find the rest");
    field("event_resolution", event_resolution, "of half a shot", 0.0001, 0.5,
          "an event's edges are halved down to it: two milliseconds");
    field(
        "event_reach", event_reach, "shots", 0.5, 1000.0,
        "that begin so near an event can show it: its edges move by one and a half, it lasts one");
    field("nuisance_sweeps", nuisance_sweeps, "sweeps", 10, 100000,
          "of coordinate descent; far more than few, weakly coupled coordinates need");
    field("pursuit", pursuit, "signatures", 1, 100,
          "taken out one after the other before the error level is taken");
    field("identify_rounds", identify_rounds, "rounds", 1, 100,
          "of a fit around its own answer; most settle after two");
    field("identify_settled", identify_settled, "objective", 1e-06, 10.0,
          "decrease that ends these rounds: a third of a deviation of one parameter");
    field("attempts", attempts, "attempts", 1, 100,
          "of a step, each ten times shorter: where friction sticks derivatives promise anything");
    field("thinned_from", thinned_from, "shots", 2, 1000000,
          "from here on the place where a fit begins is looked for on some of them");
    field("thinned_every", thinned_every, "shots", 1, 1000,
          "one of which is kept then: twenty tell where a fit begins");
    field("recalled", recalled, "s", 0.01, 1000.0,
          "where starts are sought, what joints remember is followed from so long before a shot");
    field("steps_anew", steps_anew, "steps", 1, 1000,
          "of a fit where starts and tolerances were linearised once more");
    field("steps_without", steps_without, "steps", 1, 1000,
          "of a fit without one of the effects: it begins near its end");
    field("farthest_start", farthest_start, "probes", 0.1, 100.0,
          "from the null, at most, where a fit begins: the screening is linear");
    field("beyond_orders", beyond_orders, "factor", 0.5, 100.0,
          "times the highest order that was probed: no higher one is tried");
  }
};

/// Effects that are chance: lost commands, one by one, and what scatters.
struct ChanceSettings {
  int worst_shots = 12;
  int loss_changes = 30;
  int promising = 12;
  int loss_refits = 3;
  int loss_runs = 4;
  double loss_wrong = 0.1;
  double loss_shows = 2.0;
  double loss_seen = 0.25;
  double loss_doubted = 2.0;
  double loss_mirrored = 0.03;
  double mirrored_from = 0.3;
  double mirrored_alone = 0.2;
  double loss_left = 0.03;
  int draws = 24;
  int least_draws = 8;
  int all_draws = 240;
  int sizes = 6;
  int parametric_draws = 299;
  int steps_anew = 2;
  double beyond = 1.5;
  double capped_share = 0.02;
  double margin = 1.2;
  double smallest = 12.0;
  template <class Field>
  void visit(Field&& field) {
    field("worst_shots", worst_shots, "shots", 1, 10000,
          "tried first: when no loss is found in the worst, none is behind the others");
    field("loss_changes", loss_changes, "changes", 1, 1000,
          "of a shot; at the library's largest rate half a second at 100 Hz loses 15");
    field("promising", promising, "changes", 1, 1000,
          "that were best a moment ago are tried again before all others");
    field("loss_refits", loss_refits, "refits", 1, 100,
          "of the nuisances, which took up what the losses do on average");
    field("loss_runs", loss_runs, "lengths", 1, 10,
          "of commands lost in a row that are tried at once: 1, 2, 4, ...; others grow");
    field("loss_wrong", loss_wrong, "relative", 0.001, 1.0,
          "of what a loss changes, in a tolerated model: gain, lag, mass and friction together");
    field("loss_shows", loss_shows, "factor", 0.1, 100.0,
          "of the price of a loss: one that changes more is not missed for the noise, and counted");
    field("loss_seen", loss_seen, "share", 0.0, 1.0,
          "of the losses found that a jump of the command shows, at least, or they are none");
    field("loss_mirrored", loss_mirrored, "share", 0.0001, 1.0,
          "of what losses mend that commands which go too far would: no loss does that");
    field("mirrored_from", mirrored_from, "share", 0.01, 1.0,
          "of all commands lost: from here on all of that is allowed");
    field("mirrored_alone", mirrored_alone, "share", 0.0, 1.0,
          "of that where losses are far apart: less is rounding of the search");
    field("loss_left", loss_left, "share", 0.0001, 1.0,
          "of the error beyond noise that losses may leave: of many, the smallest are not found");
    field("loss_doubted", loss_doubted, "factor", 0.1, 100.0,
          "times what a misfit may be: from here the worst shots tell enough");
    field(
        "draws", draws, "draws", 2, 10000,
        "of an effect at one size: variances of a row to 30 %, and thousands of rows are compared");
    field("least_draws", least_draws, "draws", 2, 10000,
          "where many joints share the time, at least");
    field("all_draws", all_draws, "draws", 2, 100000, "of all joints together");
    field("sizes", sizes, "sizes", 2, 100,
          "between the smallest and the largest, evenly in the logarithm");
    field("parametric_draws", parametric_draws, "draws", 19, 100000,
          "of the null law in which readings alone scatter: p resolves to 0.003");
    field("steps_anew", steps_anew, "steps", 1, 100,
          "Gauss-Newton steps where shots begin a little elsewhere");
    field("beyond", beyond, "factor", 0.5, 100.0,
          "times the scatter of the largest size: something else scatters");
    field("capped_share", capped_share, "share", 0.0001, 0.4,
          "of a channel's rows from above: no single row decides");
    field("margin", margin, "factor", 0.5, 10.0,
          "on what may be left, for what few draws get wrong");
    field("smallest", smallest, "factor", 1.5, 1000.0,
          "between the largest size of a chance that is simulated and the smallest");
  }
};

/// Durations in which a servo's reversal, breakaway or step response happens.
struct RegimeSettings {
  double reversal = 0.04;
  double standstill = 0.1;
  double breakaway = 0.06;
  double after_step = 0.15;
  double standing = 0.03;
  double saturated = 0.9;
  double near_limit = 0.03;
  double step = 6.0;
  template <class Field>
  void visit(Field&& field) {
    field("reversal", reversal, "s", 0.001, 1.0, "around a change of direction");
    field("standstill", standstill, "s", 0.001, 5.0, "shorter rests are none");
    field("breakaway", breakaway, "s", 0.001, 1.0, "after a standstill");
    field("after_step", after_step, "s", 0.001, 2.0, "after a command step");
    field("standing", standing, "share of the fastest", 0.0001, 0.5,
          "slower, a joint stands: the 99th percentile of its speed is the whole");
    field("saturated", saturated, "duty", 0.05, 2.0, "from here on a drive gives what it can");
    field("near_limit", near_limit, "share of the range", 0.0, 0.45, "of a joint, at either end");
    field("step", step, "factor", 1.0, 100.0,
          "times the 95th percentile of its changes: a command that changes more jumps");
  }
};

}  // namespace sanso::diagnose
