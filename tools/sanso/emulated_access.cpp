#include "tools/sanso/emulated_access.h"

#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>

#include "tools/inprocess/truth_frame.h"

namespace sanso::cli {

using wire::SupervisorState;

EmulatedAccess::EmulatedAccess(const std::string& world, std::uint64_t seed, const std::filesystem::path& folder)
    : world_(world), processes_(world, seed, folder), channel_(processes_.address()), clock_(channel_),
      link_(channel_, clock_, processes_.key()) {
  if (link_.open() != Status::ok)
    throw std::runtime_error("sanso-firmware does not answer:\n" + processes_.firmware_log());
  truth_ = std::make_unique<TruthSampler>(processes_.robot_directory());
}

void EmulatedAccess::wait_for(SupervisorState state, double patience_s, const char* what) {
  const Nanoseconds give_up = clock_.now() + from_seconds(patience_s);
  for (link_.poll(); link_.latest().state != state; link_.wait_observation(clock_.now() + 100 * kMillisecond)) {
    processes_.check();
    const bool fault = link_.latest().state == SupervisorState::fault && state != SupervisorState::fault;
    if (fault || clock_.now() >= give_up)
      throw std::runtime_error(fmt::format("{}: state {}, fault {} (docs/faults.md)", what, static_cast<int>(link_.latest().state),
                                           link_.latest().fault));
  }
}

/// Whatever the last trial left: lowered, or its fault cleared, torque off.
void EmulatedAccess::bring_to_idle() {
  link_.poll();
  const SupervisorState state = link_.latest().state;
  if (state == SupervisorState::fault) {
    (void)link_.command({.kind = wire::CommandKind::clear_fault});
    link_.wait_observation(clock_.now() + 100 * kMillisecond);
  } else if (state != SupervisorState::idle && state != SupervisorState::self_test && state != SupervisorState::boot) {
    (void)link_.command({.kind = wire::CommandKind::disarm});
  }
}

link::RobotLink& EmulatedAccess::place(const model::State& x, std::uint64_t) {
  processes_.check();
  bring_to_idle();
  constexpr double kLowerOrSelfTest_s = 20.0;
  wait_for(SupervisorState::idle, kLowerOrSelfTest_s, "getting ready for the next trial");
  processes_.put_on_feet(x);
  constexpr Nanoseconds kSettle = 300 * kMillisecond;  // the estimator sees where it is now
  for (const Nanoseconds end = clock_.now() + kSettle; clock_.now() < end;) link_.wait_observation(end);
  (void)truth_->take();
  return link_;
}

void EmulatedAccess::add_measurements(learn::Episode& episode) {
  const std::vector<TruthSampler::Sample> seen = truth_->take();
  if (episode.ticks.empty() || seen.empty()) return;
  std::size_t k = 0;
  const auto nearest = [&](Nanoseconds time) {  // both ascend in time
    while (k + 1 < seen.size() && std::abs(seen[k + 1].time - time) <= std::abs(seen[k].time - time)) ++k;
    return seen[k];
  };
  const inprocess::TruthFrame frame(nearest(episode.ticks.front().time).leg_state, episode.reference.front());
  for (const wire::Observation& o : episode.ticks) {
    const TruthSampler::Sample sample = nearest(o.time);
    episode.truth.push_back(frame.sample(sample.leg_state, sample.foot_load_N));
  }
}

}  // namespace sanso::cli
