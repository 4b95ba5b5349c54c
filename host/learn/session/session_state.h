// Everything a session has learned and shown so far: what is stored after every trial and read back
// to resume.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/learn/episodes/episode.h"
#include "host/learn/model/residual_trust.h"
#include "shared/policy/primitives.h"

namespace sanso::learn {

struct TrialSummary {
  std::uint32_t trial = 0;
  double cost = 0.0;
  double cost_true = -1.0;  // the same from the true states; negative: nobody can tell
  TrialEnd end = TrialEnd::completed;
  std::uint16_t fault = 0;
  double duration_s = 0.0;     // how long the motion ran
  double sigma = 0.0;          // noise amplitude of the planner
  double input_share = 1.0;    // of W_u that the planner counted
  double lifted_share = -1.0;  // of the reference's lift of feet, as believed; negative: none asked
  // N-step loss in W_x of the model in use on this trial; negative: not computed
  double model_loss = -1.0;
  double model_loss_analytical = -1.0;  // the same without the residual network
  double model_loss_initial = -1.0;     // and of the model the session began with
  double residual_share = 0.0;          // of the network's correction that the planner used
  double u_upper_rms = 0.0;             // rad, over joints and time
  double u_middle_rms = 0.0;            // rad
  double gain_upper = 0.0;              // mean Frobenius norm of K_up as used
  double gain_middle = 0.0;             // mean Frobenius norm of K_mid
  bool quiet_at_start = false;          // the robot stood still when the trial began
  std::uint32_t late_updates = 0;
  std::uint32_t bus_lost = 0, bus_corrupt = 0;
  std::uint64_t digest = 0;      // of the episode; equal for equal runs
  double wall_s = 0.0;           // measured: placing, settling, running and storing the trial
  std::vector<float> update_ms;  // measured: every policy update
  std::vector<std::string> broken_clauses;  // of the motion's success, as texts
  bool failed() const { return end != TrialEnd::completed; }
  /// Ran to its end under the cost limit and did what the motion is for.
  bool succeeded() const { return !failed() && broken_clauses.empty(); }
};

struct SessionState {
  std::string identity;  // what must agree to resume: motion, seed, layers, settings
  std::uint32_t next_trial = 0;
  double sigma = 0.0;
  double input_share = 1.0;  // of W_u that the planner counts in the next trial
  // rounds of model learning done; the model itself is stored beside
  std::uint32_t model_rounds = 0;
  ResidualTrust residual;           // in that model's network, after the newest trial
  policy::PrimitiveSet primitives;  // goals as adapted so far
  policy::MiddleTable middle;       // full precision; the controller gets it rounded
  std::vector<double> robot;        // its condition after the newest trial (robot_access.h)
  std::vector<TrialSummary> history;
};

/// What an episode says in figures, but for losses of the model, true cost and broken clauses;
/// `middle`: as it was in the trial.
TrialSummary summarize(const Episode& episode, const policy::MiddleTable& middle);

/// For people: how the trial ended, with the number of the fault that ended it (docs/faults.md).
std::string how_it_ended(const TrialSummary& trial);

/// Whole or not at all: a kill leaves the state before. Throws when it cannot be written.
void save_state(const std::filesystem::path& path, const SessionState& state);
/// Throws std::runtime_error when the file is missing or damaged. Large: filled in place.
void load_state(const std::filesystem::path& path, SessionState& state);

/// 64-bit fingerprint of what was learned (primitives and middle layer), without measured times.
std::uint64_t learned_digest(const SessionState& state);

}  // namespace sanso::learn
