// The subcommands of `sanso`: each adds itself to the command line and, when chosen, leaves its
// exit code in `result`.
// What a command does lives in the folder of its subject; here is only its grammar. DESIGN: names
// and options are stable.
#pragma once

#include <CLI/CLI.hpp>

namespace sanso::cli {

/// Exit codes of every command.
inline constexpr int kDone = 0;       // done, the answer is "good"
inline constexpr int kBadAnswer = 1;  // the answer is "bad": a mismatch, a failed motion
inline constexpr int kCouldNot = 2;   // no answer: bad input, missing file, full disk

/// All commands of this program, and what it says when it is asked for none: all_commands.cpp, or
/// demo_commands.cpp of the program that tools/demo builds.
void add_commands(CLI::App& app, int& result);
extern const char* const kNext;

void add_demo(CLI::App& app, int& result);
void add_conceal(CLI::App& app, int& result);
void add_learn(CLI::App& app, int& result);
void add_bench(CLI::App& app, int& result);
void add_motions(CLI::App& app, int& result);
void add_jog(CLI::App& motions);  // of add_motions
void add_report(CLI::App& app, int& result);
void add_reveal(CLI::App& app, int& result);
void add_identify(CLI::App& app, int& result);
void add_watch(CLI::App& app, int& result);
void add_export(CLI::App& app, int& result);
void add_import(CLI::App& app, int& result);
void add_score(CLI::App& app, int& result);
void add_diagnose(CLI::App& app, int& result);
void add_bench_diagnose(CLI::App& app, int& result);

}  // namespace sanso::cli
