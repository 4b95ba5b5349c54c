#include "tools/bench/diagnose/diagnose_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/search/parallel.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::bench {
namespace {

struct Outcome {
  unsigned long seed = 0;
  DiagnoseScore score;
  double seconds = 0.0;
};

/// A proportion that grows case by case.
struct Count {
  int hits = 0, trials = 0;
  void add(bool hit) { hits += hit, ++trials; }
  std::string text() const {
    if (trials == 0) return "-";
    const diagnose::Interval i = diagnose::wilson_interval(hits, trials);
    return fmt::format("{:5.1f} % [{:.1f}, {:.1f}] of {}", 100.0 * hits / trials, 100 * i.low, 100 * i.high, trials);
  }
};

Outcome run_case(const DiagnoseBenchOptions& options, unsigned long seed) {
  const std::filesystem::path folder =
      std::filesystem::path(options.folder) / fmt::format("{}_{}", options.robot, seed);
  std::filesystem::remove_all(folder);
  const DiagnoseCase made = options.conceal(seed, options.robot, folder.string());
  diagnose::DiagnoseOptions task;
  task.model = made.model;
  task.recordings = made.recordings;
  const auto start = std::chrono::steady_clock::now();
  const diagnose::Diagnosis found = diagnose::diagnose(task, [](const std::string&) {});
  Outcome out;
  out.seed = seed;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string verdict = (folder / "verdict.json").string();
  std::ofstream(verdict) << diagnose::verdict_json(found.verdict);
  out.score = options.reveal(folder.string(), verdict);
  return out;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : " + ") + n;
  return text.empty() ? "nothing" : text;
}

/// Scores of one family at one ratio (or of all ratios when `ratio` < 0).
void print_row(const std::vector<Outcome>& all, const std::string& family, double ratio) {
  Count right, detected, named, in_set, where, refused, unnamed, covered;
  std::vector<double> errors, sizes, f1;
  for (const Outcome& o : all) {
    const DiagnoseScore& s = o.score;
    if (s.family != family || (ratio >= 0.0 && s.ratio != ratio)) continue;
    right.add(s.right), detected.add(s.detected), named.add(s.named_first), in_set.add(s.in_set),
        where.add(s.where_exact);
    refused.add(s.refused_by_name), unnamed.add(s.unnamed);
    sizes.push_back(s.set_size), f1.push_back(s.f1);
    for (const auto& [name, e] : s.relative_error) errors.push_back(e);
    for (const auto& [name, c] : s.covered) covered.add(c);
  }
  if (right.trials == 0) return;
  fmt::print("{:<10} {:>5} right {}", family, ratio < 0.0 ? "all" : fmt::format("{:g}", ratio), right.text());
  if (family == "clean") fmt::print("   false alarms {}", detected.text());
  if (family == "decoy") fmt::print("   refused by name {}", refused.text());
  if (family == "outside") fmt::print("   unnamed {}   place {}", unnamed.text(), where.text());
  if (family == "single" || family == "pair" || family == "ambiguous") {
    fmt::print("   detected {}   name first {}   in set {} (mean size {:.2f})   place {}   f1 {:.2f}", detected.text(),
               named.text(), in_set.text(), diagnose::mean(sizes), where.text(), diagnose::mean(f1));
    if (!errors.empty())
      fmt::print("   parameter error, median {:.1f} %, covered {}", 100 * diagnose::median(errors), covered.text());
  }
  fmt::print("\n");
}

void print_table(const std::vector<Outcome>& all) {
  for (const char* family : {"clean", "decoy", "single", "pair", "outside", "ambiguous"}) {
    print_row(all, family, -1.0);
    for (const double ratio : {0.3, 1.0, 3.0, 10.0, 30.0}) print_row(all, family, ratio);
  }
}

void print_confusions(const std::vector<Outcome>& all) {
  std::map<std::string, int> pairs;
  for (const Outcome& o : all) {
    if (!o.score.right) ++pairs[joined(o.score.truth) + " -> " + o.score.status + ": " + joined(o.score.named)];
  }
  fmt::print("\nconfusions (truth -> said)\n");
  for (const auto& [pair, count] : pairs) fmt::print("  {} x {}\n", count, pair);
  fmt::print("failures, by seed\n");
  for (const Outcome& o : all) {
    if (o.score.right) continue;
    fmt::print("  seed {}: {} ratio {:g}: {} -> {} {}\n", o.seed, o.score.family, o.score.ratio, joined(o.score.truth),
               o.score.status, joined(o.score.named));
  }
}

void print_json(const std::vector<Outcome>& all) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Outcome& o : all) {
    const DiagnoseScore& s = o.score;
    out.push_back({{"seed", o.seed},
                   {"family", s.family},
                   {"ratio", s.ratio},
                   {"truth", s.truth},
                   {"named", s.named},
                   {"status", s.status},
                   {"right", s.right},
                   {"detected", s.detected},
                   {"in_set", s.in_set},
                   {"set_size", s.set_size},
                   {"where_exact", s.where_exact},
                   {"relative_error", s.relative_error},
                   {"covered", s.covered},
                   {"seconds", o.seconds}});
  }
  fmt::print("{}\n", out.dump(2));
}

}  // namespace

int bench_diagnose(const DiagnoseBenchOptions& options) {
  std::vector<Outcome> all(static_cast<std::size_t>(options.cases));
  diagnose::parallel_for(options.cases, [&](int k) {
    Outcome& o = all[static_cast<std::size_t>(k)];
    o = run_case(options, options.seed + static_cast<unsigned long>(k));
    fmt::print(stderr, "seed {}: {} ratio {:g}: {} -> {} {}: {}, {:.1f} s\n", o.seed, o.score.family, o.score.ratio,
               joined(o.score.truth), o.score.status, joined(o.score.named), o.score.right ? "right" : "wrong",
               o.seconds);
  });
  std::vector<double> seconds;
  for (const Outcome& o : all) seconds.push_back(o.seconds);
  if (options.json) {
    print_json(all);
    return 0;
  }
  fmt::print("{} cases of {}, seeds {} to {}; intervals are 95 % (Wilson)\n", options.cases, options.robot,
             options.seed, options.seed + static_cast<unsigned long>(std::max(0, options.cases - 1)));
  print_table(all);
  print_confusions(all);
  fmt::print("time of a diagnosis: median {:.1f} s, largest {:.1f} s\n", diagnose::median(seconds),
             diagnose::quantile(seconds, 1.0));
  return 0;
}

}  // namespace sanso::bench
