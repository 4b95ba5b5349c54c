// One case after the other: conceal, diagnose, reveal, count; the tables are made from the
// stored outcomes.
#include "tools/bench/diagnose/diagnose_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "shared/files/atomic_file.h"
#include "tools/bench/diagnose/baselines.h"
#include "tools/bench/diagnose/diagnose_table.h"
#include "tools/bench/diagnose/residual_network.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/wholebody/diagnose_whole.h"

namespace sanso::bench {
namespace {

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
          {"confirmed", s.confirmed},
          {"wrong_confirmed", s.wrong_confirmed},
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
  if (options.json) {
    print_json(all);
    return 0;
  }
  fmt::print("{} cases run of {} asked for, {}, seeds {} to {}; intervals are 95 % (Wilson)\n",
             all.size(), options.cases, options.robot, options.seed,
             options.seed + static_cast<unsigned long>(std::max(0, options.cases - 1)));
  print_scores(all, options.leave_out);
  return 0;
}

}  // namespace sanso::bench
