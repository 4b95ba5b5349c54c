// Counts operations with a counting number type, times the lanes, and divides by the peak of the
// same instruction set.
#include "tools/bench/bench_dynamics.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "shared/math/order_statistics.h"
#include "shared/model/kernel/step.h"
#include "shared/model/op3_kinematics.h"
#include "shared/model/op3_step.h"
#include "shared/model/step_batch.h"
#include "tools/bench/counted.h"
#include "tools/bench/peak.h"

namespace sanso::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kStep = 0.06;
constexpr int kGroups = 64;
constexpr int kRepeats = 60;

struct Sample {
  std::vector<model::StateLanes> x = std::vector<model::StateLanes>(kGroups);
  std::vector<model::InputLanes> u = std::vector<model::InputLanes>(kGroups);
  std::vector<model::StateLanes> next = std::vector<model::StateLanes>(kGroups);
};

// Standing, both soles near the ground, every lane disturbed a little: eight contacts at work.
Sample standing_sample() {
  std::mt19937 rng(1);
  std::normal_distribution<double> normal;
  Sample s;
  for (int g = 0; g < kGroups; ++g)
    for (int l = 0; l < model::kLanes; ++l) {
      model::Tangent d;
      for (double& c : d) c = 0.02 * normal(rng);
      d[model::kDPos + 2] = 0.001 * normal(rng);
      const model::State x = model::plus(model::standing_state(), d);
      for (int i = 0; i < model::kNx; ++i) s.x[g].v[i][l] = x[i];
      for (int j = 0; j < model::kNu; ++j)
        s.u[g].v[j][l] = x[model::kXJoint + j] + 0.05 * normal(rng);
    }
  return s;
}

/// Fastest and median time of one evaluation of one lane [ns].
struct Time {
  double min_ns, median_ns;
};

template <class Run>
Time time_of(Run run, double evaluations) {
  std::vector<double> ns;
  for (int i = 0; i < kRepeats; ++i) {
    const auto start = Clock::now();
    run();
    ns.push_back(std::chrono::duration<double, std::nano>(Clock::now() - start).count() /
                 evaluations);
  }
  const double fastest = *std::min_element(ns.begin(), ns.end());
  return {fastest, math::value_of_rank(std::span(ns), ns.size() / 2)};
}

Counts count_step(const model::StepModel& m, const model::Ground& ground, const Sample& s) {
  auto scratch = std::make_unique<model::portable::StepScratch<Counted>>();
  Counted x[model::kNx], u[model::kNu], next[model::kNx];
  for (int i = 0; i < model::kNx; ++i) x[i] = s.x[0].v[i][0];
  for (int j = 0; j < model::kNu; ++j) u[j] = s.u[0].v[j][0];
  counts = Counts{};
  model::portable::analytical_step(m, ground, x, u, kStep, 1, next, *scratch);
  return counts;
}

nlohmann::json measure(const char* isa, const model::StepModel& m, const model::Ground& ground,
                       Sample& s, long flops) {
  const Time t = time_of(
      [&] {
        model::step_batch(m, ground, s.x.data(), s.u.data(), {.h = kStep}, s.next.data(), nullptr,
                          kGroups);
      },
      kGroups * model::kLanes);
  const double peak = peak_flops(isa), achieved = static_cast<double>(flops) / (t.min_ns * 1e-9);
  return {{"isa", isa},
          {"ns_per_lane", t.min_ns},
          {"ns_per_lane_median", t.median_ns},
          {"gflops", achieved / 1e9},
          {"peak_gflops", peak / 1e9},
          {"share_of_peak", peak > 0 ? achieved / peak : 0.0}};
}

void print_table(const nlohmann::json& r) {
  std::printf(
      "one 60 ms step, 8 contact points, %d sweeps a round: %ld additions and multiplications, "
      "%ld divisions and roots, %ld selections\n",
      r["sweeps"].get<int>(), r["arithmetic"].get<long>(), r["divisions"].get<long>(),
      r["selections"].get<long>());
  std::printf("%-10s %14s %10s %10s %10s %8s\n", "unit", "ns per lane", "median", "GFLOP/s", "peak",
              "share");
  std::printf("%-10s %14.0f %10.0f\n", "scalar", r["scalar_ns"].get<double>(),
              r["scalar_ns_median"].get<double>());
  for (const auto& unit : r["units"])
    std::printf("%-10s %14.0f %10.0f %10.1f %10.1f %7.1f%%\n",
                unit["isa"].get<std::string>().c_str(), unit["ns_per_lane"].get<double>(),
                unit["ns_per_lane_median"].get<double>(), unit["gflops"].get<double>(),
                unit["peak_gflops"].get<double>(), 100 * unit["share_of_peak"].get<double>());
  std::printf("chosen on this machine: %s\n", r["chosen"].get<std::string>().c_str());
}

}  // namespace

int bench_dynamics(bool json) {
  const model::StepModel m = model::make_step_model(model::nominal_parameters());
  const model::Ground ground = model::make_plane();
  Sample s = standing_sample();
  const Counts c = count_step(m, ground, s);
  nlohmann::json result{{"sweeps", m.contact.sweeps},
                        {"arithmetic", c.arithmetic},
                        {"divisions", c.division},
                        {"selections", c.selection},
                        {"threads", 1},
                        {"units", nlohmann::json::array()}};
  const std::string chosen = model::batch_isa();
  result["chosen"] = chosen;

  const model::State x0 = model::standing_state();
  const model::Input u0 = model::joints(x0);
  model::StepScratch scratch;
  model::State next;
  const Time scalar = time_of(
      [&] {
        for (int i = 0; i < 100; ++i)
          model::analytical_step(m, ground, x0.data(), u0.data(), kStep, 1, next.data(), scratch);
      },
      100);
  result["scalar_ns"] = scalar.min_ns;
  result["scalar_ns_median"] = scalar.median_ns;
  for (const char* isa : {"portable", "avx2", "avx512"})
    if (model::select_batch_isa(isa))
      result["units"].push_back(measure(isa, m, ground, s, c.arithmetic + c.division));
  model::select_batch_isa(chosen.c_str());

  if (json)
    std::printf("%s\n", result.dump(2).c_str());
  else
    print_table(result);
  return 0;
}

}  // namespace sanso::bench
