// One case after the other: conceal, diagnose, reveal, count; the tables are made from the
// stored outcomes.
#include "tools/bench/diagnose/diagnose_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "shared/files/atomic_file.h"
#include "tools/bench/diagnose/baselines.h"
#include "tools/bench/diagnose/residual_network.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/wholebody/diagnose_whole.h"

namespace sanso::bench {
namespace {

struct Outcome {
  unsigned long seed = 0;
  DiagnoseScore score;
  double seconds = 0.0;                    // what a user waits
  std::map<std::string, Names> baselines;  // what simpler methods name
  bool proved = false;                     // the verdict has a held-out score at 0.5 s
  double explained = 0.0;                  // there, of the error beyond noise
  // the same by a search that knows the true effects only; 0: not asked
  double explained_by_truth = 0.0;
  ResidualNetworkScore network;
  // verdict without the true effects in the library
  std::optional<diagnose::VerdictStatus> without_status;
  Names without_named;
};

/// A proportion that grows case by case.
struct Count {
  int hits = 0, trials = 0;
  void add(bool hit) { hits += hit, ++trials; }
  std::string text() const {
    if (trials == 0) return "-";
    const diagnose::Interval i = diagnose::wilson_interval(hits, trials);
    return fmt::format("{:5.1f} % [{:.1f}, {:.1f}] of {}", 100.0 * hits / trials, 100 * i.low,
                       100 * i.high, trials);
  }
};

double explained_half_second(const diagnose::Verdict& verdict, bool& proved) {
  const auto proof = verdict.heldout.find(diagnose::Horizon::ahead(0.5));
  proved = proof != verdict.heldout.end() && proof->second.all.has_value();
  return proved ? proof->second.all->explained() : 0.0;
}

/// Of a floating base: in the balance that the true effects explain most of.
void explain_whole(const diagnose::Verdict& found, const diagnose::Verdict& told, Outcome& out) {
  const auto horizon = diagnose::Horizon::recorded_motion();
  const auto here = found.heldout.find(horizon), there = told.heldout.find(horizon);
  if (here == found.heldout.end() || there == told.heldout.end()) return;
  for (const auto& [channel, score] : there->second.channels) {
    const auto same = here->second.channels.find(channel);
    if (same == here->second.channels.end() || score.explained() <= out.explained_by_truth)
      continue;
    out.explained_by_truth = score.explained(), out.explained = same->second.explained();
    out.proved = true;
  }
}

nlohmann::ordered_json json_of(const Outcome& o) {
  const DiagnoseScore& s = o.score;
  return {{"seed", o.seed},
          {"family", to_string(s.family)},
          {"ratio", s.ratio},
          {"truth", s.truth},
          {"named", s.named},
          {"status", s.status},
          {"right", s.right},
          {"detected", s.detected},
          {"named_first", s.named_first},
          {"in_set", s.in_set},
          {"set_size", s.set_size},
          {"f1", s.f1},
          {"where_exact", s.where_exact},
          {"refused_by_name", s.refused_by_name},
          {"unnamed", s.unnamed},
          {"relative_error", s.relative_error},
          {"covered", s.covered},
          {"explained", o.explained},
          {"explained_by_truth", o.explained_by_truth},
          {"network_explained", o.network.explained},
          {"network_mismatch", o.network.mismatch},
          {"baselines", o.baselines},
          {"without_status", o.without_status ? to_string(*o.without_status) : ""},
          {"without_named", o.without_named},
          {"seconds", o.seconds}};
}

/// A case that was diagnosed, and what it is compared with afterwards.
struct Diagnosed {
  std::filesystem::path folder;
  diagnose::DiagnoseOptions task;
  diagnose::Verdict verdict;
  Outcome outcome;
};

Diagnosed conceal_case(const DiagnoseBenchOptions& options, unsigned long seed) {
  Diagnosed out;
  out.outcome.seed = seed;
  out.folder = std::filesystem::path(options.folder) / fmt::format("{}_{}", options.robot, seed);
  std::filesystem::remove_all(out.folder);
  const DiagnoseCase made = options.conceal(seed, options.robot, out.folder.string());
  out.task.model = made.model;
  out.task.recordings = made.recordings;
  out.task.settings = options.settings;
  return out;
}

void run_case(const DiagnoseBenchOptions& options, Diagnosed& done) {
  const std::filesystem::path& folder = done.folder;
  diagnose::DiagnoseOptions& task = done.task;
  task.first_look_by_group = true;
  const auto start = std::chrono::steady_clock::now();
  diagnose::Diagnosis found = diagnose::diagnose(task, [](const std::string&) {});
  Outcome& out = done.outcome;
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string verdict = (folder / "verdict.json").string();
  files::write_atomically(verdict, diagnose::verdict_json(found.verdict));
  out.score = options.reveal(folder.string(), verdict);
  const diagnose::FirstLook& look = found.first_look;
  out.baselines = {{"largest score", largest_score(look)},
                   {"fit everything", fit_everything(look)},
                   {"sparse regression", sparse_regression(look)},
                   {"friction ladder", friction_ladder(look)}};
  out.explained = explained_half_second(found.verdict, out.proved);
  // a run that is stopped keeps it
  files::write_atomically(folder / "outcome.json", json_of(out).dump(2) + "\n");
  task.first_look_by_group = false;
  done.verdict = std::move(found.verdict);
}

/// With a search that is told the true effects, with a residual network, and with a library that
/// lacks them.
void compare_case(const DiagnoseBenchOptions& options, Diagnosed& done) {
  Outcome& out = done.outcome;
  const bool hidden =
      out.score.family == CaseFamily::single || out.score.family == CaseFamily::pair;
  const bool floats = diagnose::floats(done.task.model);
  if (hidden && out.score.ratio >= 3.0) {
    diagnose::DiagnoseOptions told = done.task;
    told.effects = out.score.truth;
    const diagnose::Verdict verdict = diagnose::diagnose(told, [](const std::string&) {}).verdict;
    bool proved = false;
    if (floats)
      explain_whole(done.verdict, verdict, out);
    else
      out.explained_by_truth = explained_half_second(verdict, proved);
  }
  // the simpler methods simulate a bolted base
  if (!floats)
    out.network =
        residual_network(done.task.model, done.task.recordings, out.seed, options.settings);
  if (!floats && options.leave_out && hidden) {
    diagnose::DiagnoseOptions other = done.task;
    other.without = out.score.truth;
    const diagnose::Verdict without = diagnose::diagnose(other, [](const std::string&) {}).verdict;
    out.without_status = without.status;
    for (const diagnose::Finding& f : without.findings) out.without_named.push_back(f.effect);
  }
  files::write_atomically(done.folder / "outcome.json", json_of(out).dump(2) + "\n");
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& n : names) text += (text.empty() ? "" : " + ") + n;
  return text.empty() ? "nothing" : text;
}

/// Scores of one family at one ratio (or of all ratios when `ratio` < 0).
void print_row(const std::vector<Outcome>& all, CaseFamily family, double ratio) {
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
  fmt::print("{:<10} {:>5} right {}", to_string(family),
             ratio < 0.0 ? "all" : fmt::format("{:g}", ratio), right.text());
  if (family == CaseFamily::clean) fmt::print("   false alarms {}", detected.text());
  if (family == CaseFamily::decoy) fmt::print("   refused by name {}", refused.text());
  if (family == CaseFamily::outside)
    fmt::print("   unnamed {}   place {}", unnamed.text(), where.text());
  if (family == CaseFamily::single || family == CaseFamily::pair ||
      family == CaseFamily::ambiguous) {
    fmt::print(
        "   detected {}   name first {}   in set {} (mean size {:.2f})   place {}   f1 {:.2f}",
        detected.text(), named.text(), in_set.text(), diagnose::mean(sizes), where.text(),
        diagnose::mean(f1));
    if (!errors.empty())
      fmt::print("   parameter error, median {:.1f} %, covered {}", 100 * diagnose::median(errors),
                 covered.text());
  }
  fmt::print("\n");
}

void print_table(const std::vector<Outcome>& all) {
  for (const CaseFamily family : {CaseFamily::clean, CaseFamily::decoy, CaseFamily::single,
                                  CaseFamily::pair, CaseFamily::outside, CaseFamily::ambiguous}) {
    print_row(all, family, -1.0);
    for (const double ratio : {0.3, 1.0, 3.0, 10.0, 30.0}) print_row(all, family, ratio);
  }
}

/// Exactly the true effects and nothing else; for a clean case nothing.
bool exact(const Names& named, const std::vector<std::string>& truth) {
  return std::set<std::string>(named.begin(), named.end()) ==
         std::set<std::string>(truth.begin(), truth.end());
}

void print_baselines(const std::vector<Outcome>& all) {
  fmt::print("\nexactly the true effects named, at ratio 3 and more\n{:<20} {:<34} {:<34} {:<34}\n",
             "", "clean: nothing", "single", "pair");
  const auto row = [&](const std::string& method,
                       const std::function<Names(const Outcome&)>& names) {
    std::map<CaseFamily, Count> counts;
    for (const Outcome& o : all) {
      if (o.score.family != CaseFamily::clean && o.score.ratio < 3.0) continue;
      counts[o.score.family].add(exact(names(o), o.score.truth));
    }
    fmt::print("{:<20} {:<34} {:<34} {:<34}\n", method, counts[CaseFamily::clean].text(),
               counts[CaseFamily::single].text(), counts[CaseFamily::pair].text());
  };
  row("diagnose", [](const Outcome& o) { return o.score.named; });
  for (const char* method :
       {"largest score", "fit everything", "sparse regression", "friction ladder"}) {
    row(method, [method](const Outcome& o) {
      return o.baselines.contains(method) ? o.baselines.at(method) : Names{};
    });
  }
}

/// Of floating bases: the share of a balance's error beyond what a nominal model may be wrong by,
/// on recordings held out.
void print_explained_whole(const std::vector<Outcome>& all) {
  std::vector<double> of_truth;
  for (const Outcome& o : all) {
    if (!o.network.ran && o.explained_by_truth > 0.0)
      of_truth.push_back(o.explained / o.explained_by_truth);
  }
  if (of_truth.empty()) return;
  fmt::print(
      "\nexplained on recordings held out (ratio 3 and more), of what the true effects explain: "
      "median {:.3f}, mean {:.3f} over {} cases\n",
      diagnose::median(of_truth), diagnose::mean(of_truth), of_truth.size());
}

/// The share of the error beyond noise that is explained 0.5 s ahead on recordings held out,
/// against a residual network.
void print_explained(const std::vector<Outcome>& all) {
  fmt::print(
      "\nexplained on recordings held out, 0.5 s ahead, median (ratio 3 and more)\n{:<10} {:>5} "
      "{:>10} {:>17}   {}\n",
      "", "cases", "diagnose", "residual network", "network says mismatch");
  for (const CaseFamily family : {CaseFamily::clean, CaseFamily::single, CaseFamily::pair,
                                  CaseFamily::outside, CaseFamily::ambiguous}) {
    std::vector<double> diagnosed, network, of_truth;
    Count says;
    for (const Outcome& o : all) {
      const bool counts =
          o.score.family == family && (o.score.family == CaseFamily::clean || o.score.ratio >= 3.0);
      if (!counts || !o.proved || !o.network.ran) continue;
      diagnosed.push_back(o.explained), network.push_back(o.network.explained),
          says.add(o.network.mismatch);
      if (o.explained_by_truth > 0.0) of_truth.push_back(o.explained / o.explained_by_truth);
    }
    if (diagnosed.empty()) continue;
    fmt::print("{:<10} {:>5} {:>8.1f} % {:>15.1f} %   {}", to_string(family), diagnosed.size(),
               100 * diagnose::median(diagnosed), 100 * diagnose::median(network), says.text());
    if (!of_truth.empty()) {
      fmt::print("   of what the true structure explains: median {:.3f} over {} cases",
                 diagnose::median(of_truth), of_truth.size());
    }
    fmt::print("\n");
  }
}

/// A twin of one of the true effects.
bool names_twin(const std::string& name, const std::vector<std::string>& truth) {
  return std::any_of(truth.begin(), truth.end(),
                     [&](const std::string& id) { return diagnose::documented_twin(name, id); });
}

void print_left_out(const std::vector<Outcome>& all) {
  Count right;
  for (const Outcome& o : all) {
    if (!o.without_status || o.score.ratio < 10.0) continue;
    const bool twins =
        !o.without_named.empty() &&
        std::all_of(o.without_named.begin(), o.without_named.end(),
                    [&](const std::string& n) { return names_twin(n, o.score.truth); });
    right.add(o.without_status == diagnose::VerdictStatus::present_unnamed || twins);
    fmt::print("  without {}: {} {}\n", joined(o.score.truth), to_string(*o.without_status),
               joined(o.without_named));
  }
  fmt::print("left out of the library, ratio 10 and more: unnamed or a documented twin {}\n",
             right.text());
}

void print_confusions(const std::vector<Outcome>& all) {
  std::map<std::string, int> pairs;
  for (const Outcome& o : all) {
    if (!o.score.right)
      ++pairs[joined(o.score.truth) + " -> " + o.score.status + ": " + joined(o.score.named)];
  }
  fmt::print("\nconfusions (truth -> said)\n");
  for (const auto& [pair, count] : pairs) fmt::print("  {} x {}\n", count, pair);
  fmt::print("failures, by seed\n");
  for (const Outcome& o : all) {
    if (o.score.right) continue;
    fmt::print("  seed {}: {} ratio {:g}: {} -> {} {}\n", o.seed, to_string(o.score.family),
               o.score.ratio, joined(o.score.truth), o.score.status, joined(o.score.named));
  }
}

void print_json(const std::vector<Outcome>& all) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Outcome& o : all) out.push_back(json_of(o));
  fmt::print("{}\n", out.dump(2));
}

}  // namespace

int bench_diagnose(const DiagnoseBenchOptions& options) {
  std::vector<Diagnosed> cases;
  const auto begin = std::chrono::steady_clock::now();
  const auto late = [&] {
    const double minutes =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / 60.0;
    return options.minutes > 0.0 && minutes > options.minutes;
  };
  const auto count = static_cast<std::size_t>(std::max(0, options.cases));
  while (cases.size() < count && !late()) {
    constexpr std::size_t kAtOnce = 16;  // so many are lost, at most, where minutes end
    std::vector<Diagnosed> some(std::min(kAtOnce, count - cases.size()));
    diagnose::parallel_for(some.size(), [&](std::size_t k) {
      some[k] = conceal_case(options, options.seed + cases.size() + k);
    });
    // one after the other: two at once would not take the time that a user waits
    for (std::size_t k = 0; k < some.size() && !late(); ++k) {
      run_case(options, some[k]);
      cases.push_back(std::move(some[k]));
      const Outcome& o = cases.back().outcome;
      fmt::print(stderr, "[{}/{}] seed {}: {} ratio {:g}: {} -> {} {}: {}, {:.1f} s\n",
                 cases.size(), count, o.seed, to_string(o.score.family), o.score.ratio,
                 joined(o.score.truth), o.score.status, joined(o.score.named),
                 o.score.right ? "right" : "wrong", o.seconds);
    }
  }
  diagnose::parallel_for(cases.size(), [&](std::size_t k) {
    if (!late()) compare_case(options, cases[k]);
  });
  std::vector<Outcome> all(cases.size());
  std::transform(cases.begin(), cases.end(), all.begin(),
                 [](Diagnosed& done) { return std::move(done.outcome); });
  std::vector<double> seconds(all.size());
  std::transform(all.begin(), all.end(), seconds.begin(),
                 [](const Outcome& o) { return o.seconds; });
  if (options.json) {
    print_json(all);
    return 0;
  }
  fmt::print("{} cases run of {} asked for, {}, seeds {} to {}; intervals are 95 % (Wilson)\n",
             all.size(), options.cases, options.robot, options.seed,
             options.seed + static_cast<unsigned long>(std::max(0, options.cases - 1)));
  print_table(all);
  print_baselines(all);
  print_explained(all);
  print_explained_whole(all);
  print_confusions(all);
  if (options.leave_out) print_left_out(all);
  if (!seconds.empty()) {
    fmt::print("time of a diagnosis: median {:.1f}, 90 % {:.1f}, 99 % {:.1f}, largest {:.1f} s\n",
               diagnose::median(seconds), diagnose::quantile(seconds, 0.9),
               diagnose::quantile(seconds, 0.99), diagnose::quantile(seconds, 1.0));
  }
  return 0;
}

}  // namespace sanso::bench
