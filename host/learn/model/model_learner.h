// One learner for the whole augmented model: identification, residual network and noise amplitude,
// with held-out episodes deciding whether what was learned is used. Held out are the newest: they
// show the motion as it is run now.
// The session calls learn() every ten trials, judge_residual() after every trial, and stores its
// state.
//
// Noise amplitude (the paper fixes only its ends): sigma = 0.1 + 0.6 E / (E + E1), E the N-step
// loss of the model in use on held-out episodes, E1 = 1. A falling loss lowers sigma, from 0.7 for
// a useless model to 0.1 for a perfect one;
// at a loss of 1, below which no run fell in a feasibility study, it is half-way. It is 0.7 until a
// trial or a round has shown how good the model is.
#pragma once

#include <filesystem>
#include <optional>

#include "host/learn/model/damping_of_moves.h"
#include "host/learn/model/ensemble.h"
#include "host/learn/model/identify.h"
#include "host/learn/model/residual_training.h"
#include "host/learn/model/residual_trust.h"

namespace sanso::learn {

inline constexpr double kSigmaStart = 0.7, kSigmaFloor = 0.1;  // paper
/// Noise amplitude for an n-step loss on held-out trials: kSigmaFloor at 0, towards kSigmaStart as
/// it grows, and that where it is not finite.
double sigma_of_loss(double n_step_loss);

struct ModelLearningSettings {
  IdentifySettings identify;
  ResidualSettings residual;
  EnsembleSettings ensemble;
  bool use_residual = true;  // false: ablation "without residual"
  int window_stride_ticks = 6;
  int transition_stride_ticks = 2;
  int newest_episodes = 20;
  double tilt_limit_rad = kUprightTilt_rad;
  bool failures_teach = true;
  bool held_out_decides = true;
  bool trust_by_trials = true;
  bool set_up = true;
  int flight_ticks = 3;
  // of the initial model, around which is identified; nothing: the planner's own figures
  std::optional<model::ModelParameters> origin;

  ModelLearningSettings() {
    identify.search.population = 48;
    identify.search.elites = 10;
    identify.search.generations = 12;
    identify.max_windows = 120;
  }

  constexpr void visit(auto&& field) {
    field("window_stride_ticks", window_stride_ticks, "ticks", 1, 100,
          "identification takes a window every 60 ms: neighbours are nearly copies");
    field("transition_stride_ticks", transition_stride_ticks, "ticks", 1, 100,
          "the network takes a transition every 20 ms");
    field("newest_episodes", newest_episodes, "trials", 2, 1000000,
          "that are learned from: older ones were run with other policies; paper: all");
    field("tilt_limit_rad", tilt_limit_rad, "rad", 0.1, 3.2,
          "a base that leans more is a fall in progress, not the robot's model");
    field("failures_teach", failures_teach, "yes or no", false, true,
          "of failed trials windows of any length count, and the hold; no: 0.72 s or none");
    field("held_out_decides", held_out_decides, "yes or no", false, true,
          "what predicts the newest trials worse is not taken; no: every round is (paper)");
    field(
        "trust_by_trials", trust_by_trials, "yes or no", false, true,
        "a new network is followed by quarters, as trials bear it out; no: whole at once (paper)");
    field("set_up", set_up, "yes or no", false, true,
          "zeros of the joints, height of the ground and lag of the targets are found too; no: as "
          "drawn (paper)");
    field("flight_ticks", flight_ticks, "ticks", 0, 1000000,
          "without a loaded foot are a flight, half a model step: what is learned from ends at its "
          "landing, where a small error decides between a fall and none; 0: goes on (paper)");
    ensemble.visit(field);
  }
};

/// N-step losses of one episode under the three models the paper compares.
struct ModelLosses {
  double augmented = 0, analytical = 0, initial = 0;
};

/// What a round of learning found; for the log and the report.
struct LearningRound {
  int episodes = 0;
  ModelLosses heldout_before, heldout_after;  // on the held-out episodes
  bool identification_used = false;
  // a network passed the held-out episodes; the trials that follow decide on its share
  bool residual_kept = false;
  double residual_one_step = 0, residual_one_step_without = 0;  // held-out one-step losses in W_x
};

class ModelLearner {
 public:
  /// Begins with `initial`; `weights`: W_x, by which one-step errors are judged. One seed, one
  /// result.
  ModelLearner(const host::AugmentedModel& initial, const model::Tangent& weights,
               const ModelLearningSettings& settings, std::uint64_t seed);

  /// The model to plan with now: the residual network with its trusted share, or without when that
  /// is zero.
  host::AugmentedModel current() const;
  /// Noise amplitude of the next trials: falls as the model gets better.
  double sigma() const { return sigma_; }
  int rounds() const { return rounds_; }
  /// At least one window.
  ModelLosses losses(const std::vector<PredictionWindow>& windows) const;
  /// Empty for an episode without a window of N steps: nothing is known of a model then.
  std::optional<ModelLosses> losses(const Episode& episode) const;

  const ParameterMap& parameters() const { return map_; }

  /// N-step losses of the initial parameters and of others on the same windows.
  struct Start {
    double loss_initial = 0.0, loss = 0.0;
    bool used = false;
  };
  /// Before any round: begins at `z`, when it predicts `windows` better than the initial model.
  Start begin_at(const Eigen::VectorXd& z, const std::vector<PredictionWindow>& windows);
  /// After that: the damping that predicts those of `windows` best in which the robot moves, all
  /// else as it is. Returns it in prior deviations; nothing, and no change, when none does.
  std::optional<double> begin_damped(const std::vector<PredictionWindow>& windows,
                                     const DampingOfMovesSettings& settings);

  /// After that: all parameters by Gauss-Newton on `windows`, from where they are. Returns their
  /// N-step loss then; nothing, and no change, without windows.
  std::optional<double> begin_refined(const std::vector<PredictionWindow>& windows);

  /// Learns from the newest of `episodes` (ascending); from those that failed also what came before
  /// the fall, however short, and the hold before the trial. Fewer than two usable episodes:
  /// nothing is learned, nothing changes.
  LearningRound learn(const std::vector<Episode>& episodes);

  /// Judges the residual network on a trial run since its training. True when current() has changed
  /// by that.
  bool judge_residual(const Episode& episode);
  /// Changes after every trial: stored by the session, not with the model.
  const ResidualTrust& residual_trust() const { return trust_; }
  void set_residual_trust(const ResidualTrust& trust) { trust_ = trust; }

  /// Windows of an episode without the stretches in which the robot was already falling.
  std::vector<PredictionWindow> usable_windows(const Episode& episode) const;

  /// What a round learns from: usable_windows(), of an episode with a landing cut there, and of a
  /// failed episode, which may have none, all that the robot showed upright in trial and hold.
  std::vector<PredictionWindow> learning_windows(const Episode& episode) const;

  void save(const std::filesystem::path& path) const;
  /// Throws std::runtime_error when the file is missing, damaged, or of another set of parameters.
  void load(const std::filesystem::path& path);

 private:
  struct Data {
    std::vector<PredictionWindow> train, heldout;
  };
  double loss_at(const Eigen::VectorXd& z, const std::vector<PredictionWindow>& windows) const;
  std::vector<Episode> usable(const std::vector<Episode>& all) const;
  Data split(const std::vector<Episode>& episodes) const;
  void identify_parameters(const Data& data, LearningRound& round);
  /// The members anew, about z.
  void draw_ensemble(const std::vector<PredictionWindow>& windows);
  double prior_on(const std::vector<PredictionWindow>& windows) const;
  std::vector<PredictionWindow> some_of(const std::vector<PredictionWindow>& windows) const;
  void train_network(const std::vector<Episode>& episodes, const Data& data, LearningRound& round);
  /// N-step loss with as much of `network` as may come to be trusted.
  double loss_in_use(const host::ResidualNetwork& network,
                     const std::vector<PredictionWindow>& windows) const;
  TransitionSet transitions(const std::vector<Episode>& episodes,
                            const model::StepModel& analytical) const;

  host::AugmentedModel initial_;
  model::Tangent weights_;
  ModelLearningSettings settings_;
  std::uint64_t seed_;
  ParameterMap map_;
  Eigen::VectorXd z_;
  std::vector<Eigen::VectorXd> members_;           // as z, where an ensemble is asked for
  std::optional<host::ResidualNetwork> residual_;  // as trained, whole
  ResidualTrust trust_;
  double sigma_ = kSigmaStart;
  int rounds_ = 0;
};

}  // namespace sanso::learn
