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
  // standing in the first pose before the trial, lower and middle layer on
  double settle_s = 1.5;
  // a person, or who stands for one in an emulated robot, has let go so long after the hold began
  double let_go_s = 0.4;
  // a trial begins when trunk tilt against the first pose and its rate were below these for
  // quiet_s; after quiet_patience_s more than settle_s it begins all the same
  double quiet_tilt_rad = 0.25;
  double quiet_rate_rad_s = 0.25;
  double quiet_s = 0.1;
  double quiet_patience_s = 3.0;
  double cost_limit = 350.0;      // J_th (paper)
  double tilt_limit_rad = 0.698;  // 40 deg between the base's and the reference's vertical
  double drop_limit_m = 0.09;     // base below the reference
  // a plan from every so many observations; it holds from the next multiple on
  int upper_period_ticks = kTicksPerUpper;
  // virtual clocks only: when a plan leaves the host, after its observation
  double modelled_planning_s = 0.030;
  // real clocks: the planner returns its best after this; 0 = no budget
  double planning_budget_s = 0.0;
  double silence_limit_s = 0.5;       // no observation for so long: link lost
  SessionWatcher* watcher = nullptr;  // may be absent; outlives the trial
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
  int duration_ticks = 0;
};

/// Why a trial could not be started or carried on: not the motion's fault, nothing was learned.
struct TrialError : std::runtime_error {
  using std::runtime_error::runtime_error;
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

/// Number of the controller's fault for a fallen robot (docs/faults.md).
inline constexpr std::uint16_t kFaultFallen = 40;

/// Brings the controller from idle to hold in the first pose: uploads, arm, settle, and waits until
/// the robot is quiet. Throws FellBefore or another TrialError.
Preparation prepare_trial(link::RobotLink& robot, const TrialSetup& setup,
                          const TrialSettings& settings);

/// Runs the trial on a controller in hold. Returns when the controller is out of `run`.
Episode run_trial(link::RobotLink& robot, mpc::UpperLayer& upper, const TrialSetup& setup,
                  const TrialSettings& settings);

}  // namespace sanso::learn
