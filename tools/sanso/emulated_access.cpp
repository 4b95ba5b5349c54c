// Between trials: lower or clear, put the robot down through the control socket, wait until the
// controller says idle.
#include "tools/sanso/emulated_access.h"

#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>

#include "tools/inprocess/truth_frame.h"

namespace sanso::cli {

using wire::SupervisorState;

EmulatedAccess::EmulatedAccess(const std::string& world, std::uint64_t seed,
                               const std::filesystem::path& folder)
    : world_(world),
      processes_(world, seed, folder),
      channel_(processes_.address()),
      clock_(channel_),
      link_(channel_, clock_, processes_.key()) {
  if (link_.open() != Status::ok)
    throw std::runtime_error("sanso-firmware does not answer:\n" + processes_.firmware_log());
  truth_ = std::make_unique<TruthSampler>(processes_.robot_directory());
}

/// False when it went into a fault or took too long.
bool EmulatedAccess::reaches_idle(double patience_s) {
  const Nanoseconds give_up = clock_.now() + from_seconds(patience_s);
  for (link_.poll(); link_.latest().state != SupervisorState::idle;
       link_.wait_observation(clock_.now() + 100 * kMillisecond)) {
    processes_.check();
    if (link_.latest().state == SupervisorState::fault || clock_.now() >= give_up) return false;
  }
  return true;
}

/// Whatever the last trial left: lowered, or its fault cleared, torque off; or the self-test after
/// a start.
void EmulatedAccess::bring_to_idle() {
  // a crowded machine can make the self-test miss a reply: what a person would do is clear and look
  // again
  constexpr int kTries = 3;
  constexpr double kLowerOrSelfTest_s = 20.0;
  for (int i = 0; i < kTries; ++i) {
    lower_or_clear();
    if (reaches_idle(kLowerOrSelfTest_s)) return;
  }
  throw std::runtime_error(fmt::format(
      "getting ready for the next trial: state {}, fault {} (docs/faults.md)\n{}",
      static_cast<int>(link_.latest().state), link_.latest().fault, processes_.firmware_log()));
}

void EmulatedAccess::lower_or_clear() {
  link_.poll();
  const SupervisorState state = link_.latest().state;
  if (state == SupervisorState::fault) {
    (void)link::lower_and_clear(link_);
    for (const Nanoseconds end = clock_.now() + 100 * kMillisecond; clock_.now() < end;)
      link_.wait_observation(end);
  } else if (state != SupervisorState::idle && state != SupervisorState::self_test &&
             state != SupervisorState::boot) {
    (void)link_.command({.kind = wire::CommandKind::disarm});
  }
}

link::RobotLink& EmulatedAccess::place(const model::State& x, std::uint64_t) {
  processes_.check();
  bring_to_idle();
  processes_.put_on_feet(x);
  constexpr Nanoseconds kSettle = 300 * kMillisecond;  // the estimator sees where it is now
  for (const Nanoseconds end = clock_.now() + kSettle; clock_.now() < end;)
    link_.wait_observation(end);
  (void)truth_->take();
  return link_;
}

void EmulatedAccess::add_measurements(learn::Episode& episode) {
  const std::vector<TruthSampler::Sample> seen = truth_->take();
  if (episode.ticks.empty() || seen.empty()) return;
  std::size_t k = 0;
  const auto nearest = [&](Nanoseconds time) {  // both ascend in time
    while (k + 1 < seen.size() &&
           std::abs(seen[k + 1].time - time) <= std::abs(seen[k].time - time))
      ++k;
    return seen[k];
  };
  const inprocess::TruthFrame frame(nearest(episode.ticks.front().time).leg_state,
                                    episode.reference.front());
  for (const wire::Observation& o : episode.ticks) {
    const TruthSampler::Sample sample = nearest(o.time);
    episode.truth.push_back(
        frame.sample(sample.leg_state, sample.foot_load_N, sample.foot_clearance_m));
  }
}

}  // namespace sanso::cli
