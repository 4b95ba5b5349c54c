// A session: N trials of one motion, each run, stored and learned from. A session that was killed
// continues at the trial after the last finished one and ends with the same bits as one that was
// not.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/learn/layers/goal_adaptation.h"
#include "host/learn/layers/middle_layer.h"
#include "host/learn/model/model_learner.h"
#include "host/learn/session/bring_up.h"
#include "host/learn/session/robot_access.h"
#include "host/learn/session/session_state.h"
#include "host/learn/session/trial.h"

namespace sanso::learn {

/// The motion as a session needs it; host/motion reads it from the motion's file.
struct Task {
  std::string name;
  policy::PrimitiveSet primitives;
  mpc::CostWeights weights;
  /// The motion's own success clauses: texts of those that an episode breaks, empty when all hold.
  /// May be absent. Judged from outside where somebody can: for reports, nothing learns from it.
  std::function<std::vector<std::string>(const Episode&)> broken_clauses;
  /// Share of the reference's lift of feet that the robot itself believes it did; negative: it
  /// lifts none. May be absent.
  std::function<double(const Episode&)> lifted_share = {};
  /// On wheels: how a hand starts every trial. Until it has let go, nothing is learned about the
  /// model: it does not know the hand.
  std::optional<Push> push = {};
};

struct SessionSettings {
  int iterations = 10;
  std::uint64_t seed = 1;
  std::filesystem::path out;  // folder of the session; created
  // continue what is in `out`; without it `out` must hold no session
  bool resume = false;
  Layers layers;
  std::string world;    // for the summary
  std::string profile;  // name of a set of settings, for the summary; empty: the defaults
  std::string changed;  // "key=value ..." of settings that are not the defaults
  std::string adopted;  // what a diagnosis put into the model it begins with
  int learn_model_every = 10;
  int learn_first_after = 3;
  int learn_after_failures = 3;
  bool sigma_by_trials = true;
  double input_share_floor = 0.1;
  double input_share_step = 0.5;
  double lifted_least = 0.6;
  int hand_fades_over = 0;
  bool learn_model_in_hand = true;
  ModelLearningSettings model;
  MiddleLayerSettings middle;
  GoalAdaptationSettings goals;
  TrialSettings trial;
  BringUpSettings bring_up;

  /// The session's own; its parts have lists of their own.
  constexpr void visit(auto&& field) {
    field("learn_model_every", learn_model_every, "trials", 0, 1000000,
          "from round to round of model learning (paper: 10); 0: the model stays as it is");
    field("learn_first_after", learn_first_after, "trials", 0, 1000000,
          "a round of its own: what a robot lacks most is seen in its first trials; 0: no (paper)");
    field("learn_after_failures", learn_after_failures, "trials", 0, 1000000,
          "failed in a row bring a round of their own, and again after as many: a robot that falls "
          "at once would repeat a bad plan ten times; 0: never (paper)");
    field(
        "sigma_by_trials", sigma_by_trials, "yes or no", false, true,
        "the noise amplitude follows the N-step loss of every completed trial, which no model has "
        "learned from yet; no: from round to round");
    field("input_share_floor", input_share_floor, "1", 0.0, 1.0,
          "least share of W_u that the planner counts after trials that ran to their end with feet "
          "that hardly rose; 1: always the whole (paper)");
    field("input_share_step", input_share_step, "1", 0.01, 0.99,
          "such a trial multiplies that share, a failed one divides it, another keeps it; J is "
          "judged with the whole W_u");
    field("lifted_least", lifted_least, "1", 0.0, 1.0,
          "share of the reference's lift of feet, by the robot's own estimate, below which they "
          "hardly rose");
    field("hand_fades_over", hand_fades_over, "trials", 0, 1000000,
          "on wheels a hand travels along at the torso, evenly weaker from trial to trial and gone "
          "after so many; 0: it only pushes the robot off");
    field("learn_model_in_hand", learn_model_in_hand, "yes or no", false, true,
          "from trials with that hand too, which the model does not know: what it learns keeps the "
          "robot up when the hand goes; no: from those after it");
  }
};

class Session {
 public:
  /// Throws std::runtime_error when `out` cannot be used or, resuming, belongs to another session.
  /// `model` is what `upper` plans with at the beginning; learned models replace it there.
  Session(const Task& task, const SessionSettings& settings, RobotAccess& robot,
          mpc::UpperLayer& upper, const host::AugmentedModel& model = {});
  ~Session();

  /// Runs the trials that are left; `after_trial` sees every stored one. Throws std::runtime_error
  /// when a trial cannot be run.
  /// Ends earlier when `stop` says so between two trials.
  void run(
      const std::function<void(const TrialSummary&)>& after_trial,
      const std::function<bool()>& stop = [] { return false; });

  const SessionState& state() const { return *state_; }
  /// Trials that an earlier run of this session finished.
  int finished_before() const { return finished_before_; }

 private:
  void bring_up();
  TrialSummary run_one();
  void learn_from(const Episode& episode, const std::vector<model::State>& reference);
  double hold_of(std::uint32_t trial) const;
  Episode taught_by(const Episode& episode) const;
  bool time_to_learn_model() const;
  void learn_model();
  Episode run_episode(link::RobotLink& link, const TrialSetup& setup);
  void store();

  Task task_;
  SessionSettings settings_;
  RobotAccess& robot_;
  mpc::UpperLayer& upper_;
  std::unique_ptr<SessionState> state_;
  ModelLearner learner_;
  std::vector<model::State> x_init_;  // of the middle layer, one a knot
  int finished_before_ = 0;
};

/// The share of W_u that the planner counts in the trial after this one.
double next_input_share(double share, const TrialSummary& trial, const SessionSettings& settings);

/// Every middle-layer knot's view of what the upper layer did in an episode. Knots before the first
/// plan see its first knot, or nothing.
std::vector<UpperSample> upper_samples(const Episode& episode, bool first_knots_follow = true);

/// J of an episode with the true states in the estimates' place: what the controller believes of
/// itself, and so an error of its attitude, is left out. Negative without truth.
double cost_of_truth(const Episode& episode, const mpc::CostWeights& weights);

/// The same motion beginning at the origin of the trial, which the controller puts under the robot
/// when the trial starts.
policy::PrimitiveSet from_origin(policy::PrimitiveSet primitives);

/// x_DMP at every tick of the motion, first and last included.
std::vector<model::State> reference_of(const policy::PrimitiveSet& primitives);

}  // namespace sanso::learn
