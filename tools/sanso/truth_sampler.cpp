// A thread of its own that asks and stores under a lock, so that nobody who plans waits for it.
#include "tools/sanso/truth_sampler.h"

#include <chrono>
#include <nlohmann/json.hpp>

#include "tools/emulator/control_client.h"

namespace sanso::cli {

TruthSampler::TruthSampler(std::string robot_directory)
    : directory_(std::move(robot_directory)), thread_([this] { run(); }) {}

TruthSampler::~TruthSampler() {
  stop_ = true;
  thread_.join();
}

std::vector<TruthSampler::Sample> TruthSampler::take() {
  const std::lock_guard lock(mutex_);
  std::vector<Sample> out;
  out.swap(samples_);
  return out;
}

std::optional<TruthSampler::Sample> TruthSampler::latest() const {
  const std::lock_guard lock(mutex_);
  return latest_;
}

void TruthSampler::run() {
  using namespace std::chrono;
  for (auto next = steady_clock::now(); !stop_; next += 20ms) {
    std::this_thread::sleep_until(next);
    try {
      const auto answer =
          nlohmann::json::parse(emulator::tell_emulator(directory_, R"({"command": "truth"})"));
      Sample sample;
      sample.time = duration_cast<nanoseconds>(steady_clock::now().time_since_epoch()).count();
      sample.leg_state = answer.at("leg_state").get<std::array<double, 37>>();
      for (std::size_t foot = 0; foot < 2; ++foot)
        sample.foot_load_N[foot] = answer.at("foot_force_in_world").at(foot).at(2);
      sample.foot_clearance_m = answer.at("foot_clearance_m").get<std::array<double, 2>>();
      const std::lock_guard lock(mutex_);
      samples_.push_back(sample);
      latest_ = sample;
    } catch (
        const std::exception&) {  // a busy emulator answers next time; a figure can spare a point
    }
  }
}

}  // namespace sanso::cli
