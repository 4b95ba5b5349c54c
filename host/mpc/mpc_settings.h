// The settings of the upper layer, each declared once with unit, default and range.
#pragma once

namespace sanso::mpc {

/// Largest horizon the solver's fixed storage holds; the paper uses 12 states.
inline constexpr int kMaxHorizon = 24;

struct MpcSettings {
  // states in the horizon, N (paper: 12, with 60 ms 0.66 s of prediction)
  int horizon = 12;
  // s, one model step, one knot of the policy; a multiple of the 10 ms tick
  double dt_s = 0.06;
  int max_iterations = 12;  // iLQG iterations at most
  // stop when an iteration lowers the cost by less than this fraction
  double convergence = 2e-4;
  // tangent units, forward difference; chosen in docs/results/mpc.md
  double difference_step = 1e-6;
  // first value added to the diagonal of Quu, per rad^2
  double regularization = 1e-6;
  double gain_norm_limit = 13.0;  // Frobenius norm of K_up above which K_up is scaled down to it
  double input_limit_rad = 0.5;   // rad, |u_up| per joint
  double sigma = 0.1;             // noise amplitude, used when a request does not give its own
  // start from the last plan shifted by one knot instead of u_up = 0
  bool warm_start = false;
  int threads = 2;           // including the caller's
  bool pin_threads = false;  // bind thread i to processor i
  // predict from the observed state through the delay, tick by tick
  bool delay_prediction = true;

  /// field(name, value, lowest, highest): the file reader, the command line and the settings page
  /// walk this list.
  constexpr void visit(auto&& field) {
    field("horizon", horizon, 2, kMaxHorizon);
    field("dt_s", dt_s, 0.01, 0.12);
    field("max_iterations", max_iterations, 1, 100);
    field("convergence", convergence, 0.0, 0.1);
    field("difference_step", difference_step, 1e-7, 1e-2);
    field("regularization", regularization, 0.0, 1.0);
    field("gain_norm_limit", gain_norm_limit, 0.0, 1000.0);
    field("input_limit_rad", input_limit_rad, 0.01, 3.2);
    field("sigma", sigma, 0.0, 1.0);
    field("warm_start", warm_start, false, true);
    field("threads", threads, 1, 64);
    field("pin_threads", pin_threads, false, true);
    field("delay_prediction", delay_prediction, false, true);
  }
};

}  // namespace sanso::mpc
