// The settings of the upper layer, each declared once with unit, default, range and reason.
#pragma once

namespace sanso::mpc {

/// Largest horizon the solver's fixed storage holds; the paper uses 12 states.
inline constexpr int kMaxHorizon = 24;

struct MpcSettings {
  int horizon = 12;
  double dt_s = 0.06;
  int max_iterations = 12;
  double convergence = 2e-4;
  double difference_step = 1e-6;
  double regularization = 1e-6;
  double gain_norm_limit = 13.0;
  double input_limit_rad = 0.5;
  double sigma = 0.1;
  bool one_noise_channel = false;
  bool noise_over_root_dt = false;
  bool noise_slope = false;
  double spread = 0.0;
  bool warm_start = false;
  int threads = 2;
  bool pin_threads = false;
  bool delay_prediction = true;
  bool one_step_prediction = false;
  bool inputs_at_knots = false;

  /// field(name, value, unit, lowest, highest, reason): the command line and the settings page walk
  /// this list.
  constexpr void visit(auto&& field) {
    field("horizon", horizon, "states", 2, kMaxHorizon,
          "N of the paper, 12: eleven steps of 60 ms, 0.66 s of prediction");
    field("dt_s", dt_s, "s", 0.01, 0.12,
          "one model step and one knot of the policy (paper); a multiple of the 10 ms tick");
    field("max_iterations", max_iterations, "iterations", 1, 100,
          "of iLQG at most; from a cold start 4 to 8 are usual");
    field("convergence", convergence, "share", 0.0, 0.1,
          "an iteration that lowers the cost by less ends the search");
    field("difference_step", difference_step, "tangent units", 1e-7, 1e-2,
          "forward difference; chosen in results/mpc.md");
    field("regularization", regularization, "1/rad^2", 0.0, 1.0,
          "first value added to the diagonal of Quu");
    field(
        "gain_norm_limit", gain_norm_limit, "rad", 0.0, 1000.0,
        "Frobenius norm above which K_up is scaled down: spikes of K shake the servos; 1000: none");
    field("input_limit_rad", input_limit_rad, "rad", 0.01, 3.2,
          "of |u_up| a joint: full duty is reached at 0.31 rad of error");
    field("sigma", sigma, "1", 0.0, 1.0,
          "noise amplitude of plans outside a session; a session has its own, 0.7 falling to 0.1");
    field("one_noise_channel", one_noise_channel, "yes or no", false, true,
          "w is one number and F a column (paper, literally); no: a channel for each coordinate");
    field("noise_over_root_dt", noise_over_root_dt, "yes or no", false, true,
          "F divided by the root of dt without the root in the sampled noise (paper, literally)");
    field("noise_slope", noise_slope, "yes or no", false, true,
          "dF/dx of that noise is planned with too: one more linearisation an iteration");
    field(
        "spread", spread, "1", 0.0, 10.0,
        "amplitude of the noise by which models that fit about as well differ (model.members); 0: "
        "none");
    field(
        "warm_start", warm_start, "yes or no", false, true,
        "from the last plan moved on, or the share of it that costs least, not from 0 (paper: no)");
    field("threads", threads, "threads", 1, 64, "of the planner, the caller's among them");
    field("pin_threads", pin_threads, "yes or no", false, true, "thread i stays on processor i");
    field("delay_prediction", delay_prediction, "yes or no", false, true,
          "from the observed state through the delay; no: plan from the observed state");
    field(
        "one_step_prediction", one_step_prediction, "yes or no", false, true,
        "through the delay in one step with the mean input, the step that was identified (paper); "
        "no: 10 ms steps");
    field(
        "inputs_at_knots", inputs_at_knots, "yes or no", false, true,
        "a knot has the input of the step that begins there (paper, literally), so that the first-"
        "order hold runs half a step ahead of the plan; no: the mean of the steps beside it");
  }
};

}  // namespace sanso::mpc
