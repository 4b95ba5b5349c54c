// How both commands of the diagnosis begin and end: signals, time limit, progress with its time,
// files that are never half written, exit codes.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "tools/diagnose/model_folder/whole_body.h"
#include "tools/diagnose/run/diagnose.h"

namespace sanso::diagnose {

/// A file beside the verdict: its path in the folder, and what it holds.
struct OwnFile {
  std::string path, text;
};

/// What a command leaves behind.
struct Ending {
  Verdict verdict;
  std::optional<ModelFolder> patched;
  std::string text;                         // verdict.txt, and what the terminal shows
  std::string report;                       // report.html
  std::optional<WholeBody> patched_body{};  // instead of `patched`, of a base that floats
  std::optional<OwnFile> motion{};          // to be made next
};

/// A method, and what it can say when it was ended early, `seconds` after its start.
struct Method {
  std::function<Ending(const Progress&)> run;
  std::function<Ending(double seconds)> ended_early;
};

/// Runs the method until it is done, Ctrl-C, SIGTERM or the time limit ends it, and writes and
/// prints what it found. Exit code 0 no mismatch, 1 mismatch found, 2 refused, ended or failed.
int run_command(const DiagnoseOptions& options, const Method& method);

}  // namespace sanso::diagnose
