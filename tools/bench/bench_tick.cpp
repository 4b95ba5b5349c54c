// Runs the rig many times, sorts, prints percentiles; page faults are read from the kernel
// before and after.
#include "tools/bench/bench_tick.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "shared/math/order_statistics.h"
#include "shared/servo_bus/xm430.h"
#include "tools/bench/tick_rig.h"

namespace sanso::bench {
namespace {

constexpr int kWarmUp = 1000;
constexpr int kTicks = 20'000;

long page_faults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

struct Spread {
  double p50, p99, p999, max;  // us
};

Spread spread_of(std::vector<Nanoseconds>& samples) {
  const auto at = [&](double p) {
    return 1e-3 * static_cast<double>(math::quantile_below(std::span(samples), p));
  };
  return {at(0.5), at(0.99), at(0.999), at(1.0)};
}

}  // namespace

int bench_tick(bool json) {
  TickRig rig;
  if (!rig.start_trial()) {
    std::fprintf(stderr, "bench tick: the controller did not reach a trial (state %d, fault %d)\n",
                 static_cast<int>(rig.controller().state()),
                 static_cast<int>(rig.controller().fault()));
    return 2;
  }
  for (int i = 0; i < kWarmUp; ++i) rig.tick();
  std::vector<Nanoseconds> samples(kTicks);  // written once already: its pages are there
  const long faults_before = page_faults();
  for (Nanoseconds& sample : samples) sample = rig.tick();
  const long faults = page_faults() - faults_before;
  const Spread s = spread_of(samples);
  if (json)
    std::printf(
        "{\"tick_cpu_us\": {\"p50\": %.2f, \"p99\": %.2f, \"p99.9\": %.2f, \"max\": %.2f}, "
        "\"ticks\": %d, \"page_faults\": %ld}\n",
        s.p50, s.p99, s.p999, s.max, kTicks, faults);
  else
    std::printf(
        "controller tick, all three layers, estimator, guard, packets; %d ticks\n"
        "  CPU   p50 %.1f us   p99 %.1f us   p99.9 %.1f us   max %.1f us   (target: p99.9 under "
        "200 us)\n"
        "  page faults %ld\n",
        kTicks, s.p50, s.p99, s.p999, s.max, faults);
  return 0;
}

int bench_bus(bool json) {
  namespace bus = servo_bus;
  constexpr std::size_t kServos = model::kNumJoints, kData = bus::xm430::kFeedbackBytes;
  constexpr std::size_t kRequest = 14 + kServos, kFast = 8 + kServos * (kData + 4),
                        kOrdinary = kServos * (11 + kData);
  // read of 7 bytes and its reply
  constexpr std::size_t kGoals = 14 + 5 * kServos, kSlow = 14 + 18;
  constexpr double kReplyLatency_us = 50.0;  // per device, as measured by others on this bus
  if (json)
    std::printf("{\"cycle_us\": [");
  else
    std::printf(
        "one tick on the bus, 12 servos: read current, velocity, position; write goals; one slow "
        "read every 2nd tick\n");
  bool first = true;
  for (const std::int64_t baud : {1'000'000, 2'000'000, 3'000'000, 4'000'000}) {
    const auto us = [&](std::size_t bytes) {
      return 1e-3 * static_cast<double>(bus::wire_time_ns(bytes, baud));
    };
    const double fast = us(kRequest + kFast + kGoals + kSlow / 2) + 2 * kReplyLatency_us;
    const double ordinary =
        us(kRequest + kOrdinary + kGoals + kSlow / 2) + (kServos + 1) * kReplyLatency_us;
    if (json)
      std::printf("%s{\"baud\": %lld, \"fast\": %.0f, \"ordinary\": %.0f}", first ? "" : ", ",
                  static_cast<long long>(baud), fast, ordinary);
    else
      std::printf(
          "  %4.1f Mbaud   fast sync read %5.0f us   sync read %5.0f us   of 10000 us (USB "
          "latency not included)\n",
          1e-6 * static_cast<double>(baud), fast, ordinary);
    first = false;
  }
  if (json) std::printf("]}\n");
  return 0;
}

}  // namespace sanso::bench
