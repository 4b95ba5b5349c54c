// One trial, from a robot in hold to the episode: start, plan every 60 ms, judge, stop. The same
// code on every robot;
// what differs is the channel and the clock under the link.
#pragma once

#include <atomic>
#include <span>

#include "host/learn/episodes/episode.h"
#include "host/learn/session/watcher.h"
#include "host/link/robot_link.h"
#include "host/mpc/upper_layer.h"
#include "shared/policy/primitives.h"

namespace sanso::learn {

/// Which parts take part: the ablations of `sanso learn --without`.
struct Layers : policy::LayerSwitches {
  bool residual = true;    // the learned residual network
  bool stochastic = true;  // the noise term of the planner
};

struct TrialSettings {
  double settle_s = 1.5;
  double let_go_s = 0.4;
  double quiet_tilt_rad = 0.25;
  double quiet_rate_rad_s = 0.25;
  double quiet_s = 0.1;
  double quiet_patience_s = 3.0;
  double cost_limit = 350.0;
  double tilt_limit_rad = 0.698;
  double drop_limit_m = 0.09;
  int upper_period_ticks = kTicksPerUpper;
  double modelled_planning_s = 0.030;
  double planning_budget_s = 0.0;
  double silence_limit_s = 0.5;
  SessionWatcher* watcher = nullptr;  // may be absent; outlives the trial

  constexpr void visit(auto&& field) {
    field("settle_s", settle_s, "s", 0.0, 30.0,
          "in the first pose before the trial, lower and middle layer on");
    field("let_go_s", let_go_s, "s", 0.0, 30.0,
          "after the hold began a person, or who stands for one, has let go");
    field("quiet_tilt_rad", quiet_tilt_rad, "rad", 0.0, 3.2,
          "a trial begins with the trunk nearer to the first pose than this");
    field("quiet_rate_rad_s", quiet_rate_rad_s, "rad/s", 0.0, 100.0,
          "and turning slower than this: a robot that falls is past both");
    field("quiet_s", quiet_s, "s", 0.0, 10.0, "for so long");
    field("quiet_patience_s", quiet_patience_s, "s", 0.0, 1000.0,
          "after settle_s; then it begins all the same and says so");
    field("cost_limit", cost_limit, "1", 1.0, 1e9, "J_th (paper: 350); the motion's file has it");
    field("tilt_limit_rad", tilt_limit_rad, "rad", 0.1, 3.2,
          "between the verticals of base and reference; the motion's file has it");
    field("drop_limit_m", drop_limit_m, "m", 0.01, 1.0,
          "base below the reference; the motion's file has it");
    field("upper_period_ticks", upper_period_ticks, "ticks", 1, 12,
          "of 10 ms, from plan to plan; a plan holds from the next multiple on (paper: 6)");
    field("modelled_planning_s", modelled_planning_s, "s", 0.0, 0.06,
          "virtual clocks: a plan leaves the host so long after its observation, on every machine");
    field("planning_budget_s", planning_budget_s, "s", 0.0, 1.0,
          "real clocks: the planner returns its best after this; 0: no budget");
    field("silence_limit_s", silence_limit_s, "s", 0.05, 60.0,
          "without an observation: the link is lost");
  }
};

/// What one trial is made of. Everything must outlive run_trial().
struct TrialSetup {
  // new for every trial of a controller's life, never 0
  std::uint32_t trial_id = 1;
  const policy::PrimitiveSet* primitives = nullptr;
  std::span<const model::State> reference;      // x_DMP at every tick of the trial
  const policy::MiddleTable* middle = nullptr;  // values rounded to the wire
  mpc::CostWeights weights;
  Layers layers;
  double sigma = 0.1;
  double input_share = 1.0;  // of W_u that the planner counts; the trial is judged with the whole
  int duration_ticks = 0;
};

/// Why a trial could not be started or carried on: not the motion's fault, nothing was learned.
struct TrialError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Somebody pressed the emergency stop before the trial began.
struct StoppedBefore : TrialError {
  using TrialError::TrialError;
};

/// What was seen between arming and the trial.
struct Preparation {
  std::vector<wire::Observation> seen;  // the hold, without its first let_go_s
  bool quiet = false;                   // at the end of it; false: waited for long enough
};

/// The robot fell while it stood up or held its first pose. What was seen until then can be learned
/// from.
struct FellBefore : TrialError {
  FellBefore(const std::string& what, Preparation before)
      : TrialError(what), preparation(std::move(before)) {}
  Preparation preparation;
};

/// Numbers of the controller's faults: fallen, emergency stop (docs/faults.md).
inline constexpr std::uint16_t kFaultFallen = 40, kFaultEmergencyStop = 42;

/// Uploads the set and waits until the controller holds it. Throws TrialError when it is refused.
void upload_primitives(link::RobotLink& robot, const policy::PrimitiveSet& set);

/// Brings the controller from idle to hold in the first pose: uploads, arm, settle, and waits until
/// the robot is quiet. Throws FellBefore or another TrialError.
Preparation prepare_trial(link::RobotLink& robot, const TrialSetup& setup,
                          const TrialSettings& settings);

/// Runs the trial on a controller in hold. Returns when the controller is out of `run`.
Episode run_trial(link::RobotLink& robot, mpc::UpperLayer& upper, const TrialSetup& setup,
                  const TrialSettings& settings);

}  // namespace sanso::learn
