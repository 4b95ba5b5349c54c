// Runs the diagnosis over a folder of cases and keeps every outcome, so that a stopped run goes on.
#include "tools/bench/diagnose/folder_bench.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"
#include "shared/files/json.h"
#include "tools/bench/diagnose/outcome_json.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/run/score.h"
#include "tools/recording/mcap_recording.h"

namespace sanso::bench {
namespace {

namespace fs = std::filesystem;
constexpr double kProofSeconds = 0.5;  // the horizon at which fits are judged

/// Errors of the held-out recordings, window by window, nominal and patched.
void prove(const CaseFiles& c, const diagnose::Diagnosis& found, CaseOutcome& out) {
  if (c.heldout.empty() || c.answer.noise <= 0.0) return;
  const diagnose::ModelFolder nominal = diagnose::read_model_folder(c.model);
  std::vector<double> before, after;
  for (const std::string& file : c.heldout) {
    const recording::Recording r = recording::read_recording(file);
    const std::vector<double> b = diagnose::window_errors(nominal, r, kProofSeconds);
    const std::vector<double> a =
        found.patched ? diagnose::window_errors(*found.patched, r, kProofSeconds) : b;
    before.insert(before.end(), b.begin(), b.end());
    after.insert(after.end(), a.begin(), a.end());
  }
  out.proved = !before.empty();
  out.explained = explained_share(before, after, c.answer.noise, false);
  out.explained_bounded = explained_share(before, after, c.answer.noise, true);
}

CaseOutcome run_case(const CaseFiles& c, const fs::path& folder,
                     const diagnose::Settings& settings) {
  diagnose::DiagnoseOptions task;
  task.settings = settings;
  task.model = c.model;
  task.recordings = c.recordings;
  CaseOutcome out;
  out.name = c.name;
  out.family = c.answer.family;
  out.robot = c.answer.robot;
  out.ratio = c.answer.ratio;
  out.oracle_explained = c.answer.oracle_explained;
  for (const TrueEffect& e : c.answer.effects) out.truth.push_back(e.id);
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor = std::clock();
  const auto used = [processor] {
    return static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
  };
  fs::create_directories(folder);
  std::ofstream log(folder / "progress.txt");  // with s of the processor, so that it tells where
  const diagnose::Diagnosis found = diagnose::diagnose(task, [&](const std::string& line) {
    log << fmt::format("{:7.1f} s  {}", used(), line) << std::endl;
  });
  out.cpu_seconds = used();
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string verdict = diagnose::verdict_json(found.verdict);
  out.said = judge(c.answer, verdict);
  try {
    prove(c, found, out);
  } catch (const files::InputError& error) {  // a decoy may be broken there too
    fmt::print(stderr, "{}: nothing is held out: {}\n", c.name, error.what());
  }
  files::write_atomically(folder / "verdict.json", verdict);
  files::write_atomically(folder / "outcome.json", nlohmann::json(out).dump(2) + "\n");
  return out;
}

std::string list(const std::vector<std::string>& names) {
  return names.empty() ? "nothing" : fmt::format("{}", fmt::join(names, " + "));
}

}  // namespace

double bounded_error(double rms, double noise) {
  const double z = rms * rms / (noise * noise);
  return 50.0 * std::log1p(z / 50.0);
}

double explained_share(const std::vector<double>& nominal, const std::vector<double>& patched,
                       double noise, bool bounded) {
  const auto measure = [&](double rms) {
    return bounded ? bounded_error(rms, noise) : rms * rms / (noise * noise);
  };
  double before = 0.0, after = 0.0;
  for (std::size_t k = 0; k < nominal.size(); ++k) {
    before += measure(nominal[k]), after += measure(patched[k]);
  }
  const double beyond = before - measure(noise) * static_cast<double>(nominal.size());
  return beyond > 0.0 ? (before - after) / beyond : 0.0;
}

int bench_folder(const FolderBenchOptions& options) {
  const std::vector<CaseFiles> cases = read_cases(options.folder);
  std::vector<CaseOutcome> all;
  for (const CaseFiles& c : cases) {
    const fs::path folder = fs::path(options.out) / c.name;
    const fs::path outcome = folder / "outcome.json";
    if (options.resume && fs::exists(outcome)) {
      all.push_back(files::read_json(outcome).get<CaseOutcome>());
    } else {
      all.push_back(run_case(c, folder, options.settings));
    }
    const CaseOutcome& o = all.back();
    fmt::print(stderr,
               "[{}/{}] {}: {} {} ratio {:.1f}: {} -> {} {}: {}, {:.1f} s (processor {:.1f} s)\n",
               all.size(), cases.size(), o.name, in_answers(o.family), o.robot, o.ratio,
               list(o.truth), to_string(o.said.status), list(o.said.named),
               o.said.right ? "right" : "wrong", o.seconds, o.cpu_seconds);
  }
  fmt::print("{}", options.json ? folder_json(all) : folder_table(all, options.ratio_bounds));
  return 0;
}

}  // namespace sanso::bench
