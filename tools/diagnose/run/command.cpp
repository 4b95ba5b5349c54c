// The command around the method: progress lines, signals, files that are never half written, exit
// codes.
#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <filesystem>

#include "shared/files/atomic_file.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/run/diagnosis_report.h"

namespace sanso::diagnose {
namespace {

void write_all(const Diagnosis& d, const std::string& out) {
  std::filesystem::create_directories(out);
  const std::filesystem::path folder(out);
  if (d.patched) write_model_folder(*d.patched, (folder / "model").string());
  files::write_atomically(folder / "report.html", diagnosis_report(d));
  // last: it says that the others are there
  files::write_atomically(folder / "verdict.json", verdict_json(d.verdict));
}

void print_summary(const Verdict& v) {
  fmt::print("question   where do simulation and recording part, and what is missing?\n");
  fmt::print("answer     {}: {}\n", to_string(v.status), v.answer);
  if (v.status == VerdictStatus::refused) {
    for (const Defect& d : v.refused) {
      fmt::print("refused    {} {}{}: {}: {}\n", d.file, d.channel,
                 d.row >= 0 ? fmt::format(" row {}", d.row) : "", d.defect, d.message);
    }
    return;
  }
  for (const Finding& f : v.findings) {
    for (const auto& [name, p] : f.parameters) {
      fmt::print("           {}.{} = {:.4g} {} [{:.4g}, {:.4g}]{}\n", f.effect, name, p.value,
                 p.unit, p.low, p.high, p.at_bound ? " (at the library's bound)" : "");
    }
    for (const Rival& r : f.rivals) {
      if (r.said_wrong.empty())
        fmt::print("not        {}: {:.1f} standard errors behind on held-out data\n", r.effect,
                   r.behind_in_se);
      else
        fmt::print("not        {}: {}\n", r.effect, r.said_wrong);
    }
  }
  for (const auto& [horizon, scores] : v.heldout) {
    const auto all = scores.find("all");
    if (all == scores.end()) continue;
    fmt::print("held out   {} s: {:.4g} -> {:.4g} (noise {:.2g})\n", horizon, all->second.nominal,
               all->second.patched, all->second.noise);
  }
  if (v.next_experiment) fmt::print("next       {}\n", v.next_experiment->what);
}

extern "C" void on_interrupt(int) { request_stop(); }

}  // namespace

int run_diagnose(const DiagnoseOptions& options) {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
  try {
    const Diagnosis d = diagnose(options, [&](const std::string& line) {
      if (!options.quiet) std::fprintf(stderr, "diagnose: %s\n", line.c_str());
    });
    if (!options.out.empty()) write_all(d, options.out);
    if (options.json)
      fmt::print("{}", verdict_json(d.verdict));
    else
      print_summary(d.verdict);
    if (d.verdict.status == VerdictStatus::refused) return 2;
    return d.verdict.mismatch ? 1 : 0;
  } catch (const Interrupted&) {
    std::fprintf(stderr, "diagnose: interrupted, nothing written\n");
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "diagnose: %s\n", error.what());
    return 2;
  }
}

}  // namespace sanso::diagnose
