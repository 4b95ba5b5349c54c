// How long things take on the machine at hand, as histograms that the tick fills and anybody may
// read: fixed size, one writer, nobody waits.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "shared/base/time.h"

namespace sanso::firmware {

/// Counts durations in bins of a quarter of an octave: 1 us to 67 ms, what is beyond in the outer
/// ones.
class TimeHistogram {
 public:
  static constexpr std::size_t kPerOctave = 4, kBins = 16 * kPerOctave + 1;

  /// By one thread; others may read meanwhile.
  void add(Nanoseconds duration) {
    bins_[bin_of(duration)].fetch_add(1, std::memory_order_relaxed);
    if (duration > longest_.load(std::memory_order_relaxed))
      longest_.store(duration, std::memory_order_relaxed);
  }
  /// How many durations fell into a bin; below, into all.
  std::uint32_t count(std::size_t bin) const { return bins_[bin].load(std::memory_order_relaxed); }
  std::uint64_t count() const {
    std::uint64_t sum = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) sum += count(bin);
    return sum;
  }
  /// Of all so far; 0: none.
  Nanoseconds longest() const { return longest_.load(std::memory_order_relaxed); }

  /// What is in `bin` took less than this.
  static constexpr Nanoseconds end_of(std::size_t bin) {
    return bin + 1 >= kBins ? INT64_MAX : begin_of(bin + 1);
  }
  /// What is in `bin` took at least this.
  static constexpr Nanoseconds begin_of(std::size_t bin) {
    if (bin == 0) return 0;
    const std::size_t step = bin - 1;
    const Nanoseconds octave = kMicrosecond << (step / kPerOctave);
    return octave + octave * static_cast<Nanoseconds>(step % kPerOctave) /
                        static_cast<Nanoseconds>(kPerOctave);
  }
  static constexpr std::size_t bin_of(Nanoseconds duration) {
    if (duration < kMicrosecond) return 0;
    const auto us = static_cast<std::uint64_t>(duration / kMicrosecond);
    const auto octave = static_cast<std::size_t>(std::bit_width(us) - 1);
    if (octave >= 16) return kBins - 1;
    const auto within =
        static_cast<std::size_t>((duration - (kMicrosecond << octave)) *
                                 static_cast<Nanoseconds>(kPerOctave) / (kMicrosecond << octave));
    return 1 + octave * kPerOctave + within;
  }
  /// At least `share` of all took less than this; 0 of none.
  Nanoseconds quantile(double share) const {
    const double wanted = share * static_cast<double>(count());
    double sum = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      sum += count(bin);
      if (sum > 0 && sum >= wanted) return end_of(bin) < longest() ? end_of(bin) : longest();
    }
    return 0;
  }

 private:
  std::array<std::atomic<std::uint32_t>, kBins> bins_{};
  std::atomic<Nanoseconds> longest_{0};
};

struct TickTimes {
  TimeHistogram wake;     // from when the tick was due to its first instruction
  TimeHistogram tick;     // from there to its end, on the wall's clock
  TimeHistogram reply;    // from the request to the last servo's reply, within the tick
  TimeHistogram imu_age;  // of the sample that the tick uses
};

}  // namespace sanso::firmware
