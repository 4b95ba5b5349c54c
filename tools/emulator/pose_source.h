// Stand-in for a tracking camera: base position, orientation and velocity from outside, with rate,
// noise and delay.
#pragma once

#include <deque>

#include "shared/base/pose_report.h"
#include "shared/base/time.h"
#include "tools/plant/plant.h"
#include "tools/plant/random.h"
#include "tools/plant/vec.h"

namespace sanso::emulator {

class PoseSource {
 public:
  PoseSource(const plant::PoseParameters& parameters, std::uint64_t seed)
      : parameters_(parameters), random_(seed) {}

  /// Called every millisecond.
  void update(Nanoseconds now, const plant::BaseMotion& base, bool lost);
  /// One report whose delay has passed by `now`, 0 = none.
  std::size_t read(std::span<std::uint8_t> out, Nanoseconds now);

 private:
  struct Sample {
    Nanoseconds due = 0;
    PoseReport report;
  };
  plant::PoseParameters parameters_;
  void drift();
  plant::Random random_;
  plant::Vec3 drift_{};
  Nanoseconds next_ = 0;
  Nanoseconds back_ = 0;  // a drop-out ends here
  std::uint32_t sequence_ = 0;
  std::deque<Sample> samples_;
};

}  // namespace sanso::emulator
