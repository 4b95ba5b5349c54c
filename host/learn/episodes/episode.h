// An episode: everything one trial showed. Stored exactly, one file a trial; learning and reports
// read it back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/policy/policy_types.h"
#include "shared/wire/messages.h"

namespace sanso::learn {

/// Why a trial ended.
enum class TrialEnd : std::uint8_t {
  completed = 0,   // ran to its last tick
  cost_limit = 1,  // J above the threshold
  tilt = 2,        // base leaned too far
  low_base = 3,    // base too far below the reference
  fault = 4,       // the controller latched a fault (number in Episode::fault)
  link_lost = 5,   // no observation for too long
  // the controller left the trial before its time (it lost the host, or was told to stop)
  ended_early = 6,
  fell_before = 7,  // while standing up or holding the first pose; there are no ticks
};
/// As reports and summary.json say it: "completed", "fell before the trial", ...
const char* to_string(TrialEnd end);

/// One answer of the upper layer, as it was sent.
struct PlanRecord {
  policy::UpperPolicy policy;
  std::int32_t observed_tick = 0;  // trial tick of the observation it was planned from
  // measured wall time from observation to policy; reported, never used
  double update_ms = 0.0;
  double cost_before = 0.0;  // predicted cost of the horizon without the upper layer
  double cost_after = 0.0;   // and with the plan
  double gain_norm = 0.0;    // Frobenius norm of the first K before the limit
  std::uint8_t late = 0;     // 1: reached the controller after its first tick
};

/// What somebody outside the controller saw: the emulated world knows it, a real robot's laboratory
/// may not.
struct TrueSample {
  // in the frame of the reference (as it stood when the trial began)
  model::State x = model::neutral_state();
  std::array<float, 2> foot_load_N{};  // normal force, right and left
  // of the lowest sole point from the ground below it, which may lean and have plates
  std::array<float, 2> foot_clearance_m{};
};

struct Episode {
  std::uint32_t trial = 0;
  std::uint64_t seed = 0;
  TrialEnd end = TrialEnd::completed;
  std::uint16_t fault = 0;
  double cost = 0.0;                     // J, sum over the 60 ms ticks
  std::vector<double> cost_terms;        // its summands, one a 60 ms tick
  std::vector<wire::Observation> ticks;  // every 10 ms of the trial, trial_tick ascending
  std::vector<std::array<float, model::kNx>> reference;  // x_DMP at every entry of `ticks`
  std::vector<PlanRecord> plans;
  // holding the first pose, every 10 ms until the trial began, nobody's hand at the robot; outside
  // the digest, which is of the trial itself
  std::vector<wire::Observation> before;
  bool quiet_at_start = false;
  // one for every entry of `ticks`; empty when nobody can tell
  std::vector<TrueSample> truth;
  bool failed() const { return end != TrialEnd::completed; }
};

/// The plan that the controller said it was executing at an observation; null when none.
const policy::UpperPolicy* executed_policy(const Episode& episode,
                                           const wire::Observation& observation);

/// A 64-bit fingerprint of everything that must repeat: all but measured times. Equal runs have
/// equal digests.
std::uint64_t digest(const Episode& episode);

/// Where a session keeps a trial, counted from 0.
std::filesystem::path trial_file(const std::filesystem::path& session, std::uint32_t trial);
/// Throws files::InputError or std::runtime_error with the file's name: cannot be written; is not
/// there, is damaged, is of another version.
void save_episode(const std::filesystem::path& path, const Episode& episode);
Episode load_episode(const std::filesystem::path& path);

}  // namespace sanso::learn
