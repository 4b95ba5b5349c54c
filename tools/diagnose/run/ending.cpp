// The first signal ends the method at its next task and its findings are written; a second one
// ends the program.
#include "tools/diagnose/run/ending.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "shared/files/atomic_file.h"
#include "tools/diagnose/compare/parallel.h"

namespace sanso::diagnose {
namespace {

extern "C" void on_signal(int number) {
  request_stop();
  std::signal(number, SIG_DFL);
}

/// SIGALRM after `seconds`; 0: never.
void listen(double seconds) {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGALRM, on_signal);
  if (seconds > 0.0) alarm(static_cast<unsigned>(std::max(1.0, std::ceil(seconds))));
}

void write_all(const Ending& ending, const std::string& out) {
  std::filesystem::create_directories(out);
  const std::filesystem::path folder(out);
  if (ending.patched) write_model_folder(*ending.patched, (folder / "model").string());
  if (ending.patched_body) write_whole_body(*ending.patched_body, (folder / "model").string());
  if (ending.motion) {
    std::filesystem::create_directories((folder / ending.motion->path).parent_path());
    files::write_atomically(folder / ending.motion->path, ending.motion->text);
  }
  files::write_atomically(folder / "report.html", ending.report);
  files::write_atomically(folder / "verdict.txt", ending.text);
  // last: it says that the others are there
  files::write_atomically(folder / "verdict.json", verdict_json(ending.verdict));
}

int leave(const Ending& ending, const DiagnoseOptions& options) {
  if (!options.out.empty()) write_all(ending, options.out);
  fmt::print("{}", options.json ? verdict_json(ending.verdict) : ending.text);
  const VerdictStatus status = ending.verdict.status;
  if (status == VerdictStatus::refused || status == VerdictStatus::unfinished) return 2;
  return ending.verdict.mismatch ? 1 : 0;
}

}  // namespace

int run_command(const DiagnoseOptions& options, const Method& method) {
  listen(options.time_limit);
  const auto begin = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const Progress progress = [&](const std::string& line) {
    if (!options.quiet) std::fprintf(stderr, "diagnose: %6.1f s  %s\n", seconds(), line.c_str());
  };
  try {
    return leave(method.run(progress), options);
  } catch (const Interrupted&) {
    progress("ended early: writing what was found so far");
    return leave(method.ended_early(seconds()), options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diagnose: %s\n", error.what());
    return 2;
  }
}

}  // namespace sanso::diagnose
