// Asks the emulator 50 times a second what really is, from a thread of its own: for reports, never
// for control.
#pragma once

#include <array>
#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "shared/base/time.h"

namespace sanso::cli {

class TruthSampler {
 public:
  struct Sample {
    // CLOCK_MONOTONIC, as the controller's on the same machine
    Nanoseconds time = 0;
    std::array<double, 37> leg_state{};   // order of the state layout, world frame
    std::array<double, 2> foot_load_N{};  // right, left
    std::array<double, 2> foot_clearance_m{};
  };

  explicit TruthSampler(std::string robot_directory);
  ~TruthSampler();
  TruthSampler(const TruthSampler&) = delete;
  TruthSampler& operator=(const TruthSampler&) = delete;

  /// All samples since the last call.
  std::vector<Sample> take();
  /// The newest one, taken or not.
  std::optional<Sample> latest() const;

 private:
  void run();
  std::string directory_;
  mutable std::mutex mutex_;
  std::vector<Sample> samples_;
  std::optional<Sample> latest_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sanso::cli
