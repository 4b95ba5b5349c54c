// `sanso bench diagnose`: joins the maker of concealed cases with the diagnosis; neither knows the
// other.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/bench/diagnose/diagnose_bench.h"
#include "tools/bench/diagnose/folder_bench.h"
#include "tools/bench/diagnose/scaled_setting.h"
#include "tools/bench/diagnose/sensitivity.h"
#include "tools/conceal/conceal.h"
#include "tools/conceal/reveal.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {
namespace {

double nearest_ratio(double reached) {
  double nearest = 0.3;
  for (const double r : {0.3, 1.0, 3.0, 10.0, 30.0}) {
    if (std::abs(std::log(r / std::max(reached, 1e-6))) <
        std::abs(std::log(nearest / std::max(reached, 1e-6))))
      nearest = r;
  }
  return nearest;
}

bench::CaseFamily family_of(conceal::Family family) {
  switch (family) {
    case conceal::Family::clean:
      return bench::CaseFamily::clean;
    case conceal::Family::single:
      return bench::CaseFamily::single;
    case conceal::Family::pair:
      return bench::CaseFamily::pair;
    case conceal::Family::decoy:
      return bench::CaseFamily::decoy;
    case conceal::Family::outside:
      return bench::CaseFamily::outside;
    case conceal::Family::ambiguous:
      return bench::CaseFamily::ambiguous;
  }
  return bench::CaseFamily::clean;
}

bench::DiagnoseScore opened(const conceal::Score& s) {
  bench::DiagnoseScore out;
  out.family = family_of(s.family);
  out.ratio = s.ratio_target;
  // a size at its physical limit may reach less than was asked for: cases count under the ratio
  // that they have
  if (!s.ratios.empty())
    out.ratio = nearest_ratio(*std::min_element(s.ratios.begin(), s.ratios.end()));
  out.truth = s.truth;
  out.named = s.named;
  out.status = s.status;
  out.detected = s.detected, out.named_first = s.named_first, out.in_set = s.in_set,
  out.where_exact = s.where_exact;
  out.confirmed = s.confirmed;
  out.wrong_confirmed = s.wrong_confirmed;
  out.refused_by_name = s.refused_by_name, out.unnamed = s.unnamed, out.right = s.right;
  out.set_size = s.set_size, out.f1 = s.f1;
  out.relative_error = s.relative_error;
  out.covered = s.covered;
  return out;
}

struct Options {
  bench::DiagnoseBenchOptions bench;
  bench::FolderBenchOptions cases;
  bool sensitivity = false;
  std::vector<std::string> only;
  std::string family, effect;
  std::vector<std::string> settings;
  double ratio = 0.0;
};

int run_sensitivity(const Options& options) {
  if (options.cases.folder.empty()) throw CLI::RequiredError("--folder, with --sensitivity,");
  try {
    return bench::bench_sensitivity(
        {options.cases.folder, options.bench.folder, options.only, options.cases.resume});
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError("--only", error.what());
  }
}

/// Cases that somebody else made, in the place of new ones.
void add_folder_options(CLI::App& command, Options& options) {
  command.add_option("--folder", options.cases.folder,
                     "score the cases of this folder (model/, rec_*.csv, heldout/, answer.json "
                     "each) instead of concealing new ones");
  command.add_flag("--resume", options.cases.resume,
                   "with --folder: keep the outcomes that are in the working folder");
  CLI::Option* sensitivity = command.add_flag(
      "--sensitivity", options.sensitivity,
      "with --folder: ask every case with every setting halved and doubled; print what changes");
  command.add_option("--only", options.only, "with --sensitivity: these settings or groups alone")
      ->needs(sensitivity);
}

}  // namespace

void add_bench_diagnose(CLI::App& app, int& result) {
  auto options = std::make_shared<Options>();
  // `bench` may exist already with the benchmarks that take no options; "diagnose" then stands
  // beside them
  const auto existing =
      app.get_subcommands([](const CLI::App* a) { return a->get_name() == "bench"; });
  CLI::App* group =
      existing.empty()
          ? app.add_subcommand("bench", "measure against the budgets")->require_subcommand(1)
          : existing.front();
  if (CLI::Option* what = group->get_option_no_throw("what")) what->required(false);
  CLI::App* command =
      group->add_subcommand("diagnose", "conceal, diagnose and reveal cases; print the scores");
  options->bench.folder =
      (std::filesystem::temp_directory_path() / "sanso_bench_diagnose").string();
  command->add_option("--cases", options->bench.cases, "how many")->capture_default_str();
  command->add_option("--seed", options->bench.seed, "of the first case; the others follow")
      ->capture_default_str();
  command->add_option("--robot", options->bench.robot, "pendulum, arm, op3-stand or op3-floor")
      ->capture_default_str();
  command->add_option("--family", options->family,
                      "only clean, single, pair, decoy, outside or ambiguous cases");
  command->add_option("--effect", options->effect, "only this effect hidden");
  command->add_option("--ratio", options->ratio, "only this severity");
  add_folder_options(*command, *options);
  command->add_option("--work", options->bench.folder, "where cases and outcomes are put")
      ->capture_default_str();
  command->add_option("--minutes", options->bench.minutes,
                      "begin no case later than this; 0: run all");
  command->add_flag("--leave-out", options->bench.leave_out,
                    "diagnose every case again without its true effects in the library");
  command->add_option("--setting", options->settings,
                      "scale settings of the diagnosis, e.g. decisions.family_wise=0.5");
  command->add_flag("--json", options->bench.json, "print every case as JSON");
  command->footer(
      "Examples:\n"
      "  sanso bench diagnose --family single --ratio 10 --cases 20 --seed 7\n"
      "  sanso bench diagnose --folder $SANSO_DATA/concealed --resume --work out");
  command->callback([options, &result] {
    for (const std::string& change : options->settings) {
      try {
        options->bench.settings = bench::scaled(options->bench.settings, change);
      } catch (const std::invalid_argument& error) {
        throw CLI::ValidationError("--setting", error.what());
      }
    }
    if (options->sensitivity) {
      result = run_sensitivity(*options);
      return;
    }
    if (!options->cases.folder.empty()) {
      options->cases.out = options->bench.folder;
      options->cases.json = options->bench.json;
      options->cases.settings = options->bench.settings;
      result = bench::bench_folder(options->cases);
      return;
    }
    options->bench.conceal = [options](unsigned long seed, const std::string& robot,
                                       const std::string& folder) {
      conceal::ConcealOptions c;
      c.seed = seed;
      c.robot = robot;
      c.out = folder;
      if (!options->family.empty()) c.family = conceal::family_from_string(options->family);
      if (!options->effect.empty()) c.effect = options->effect;
      if (options->ratio > 0.0) c.ratio = options->ratio;
      const conceal::Concealed made = conceal::conceal(c);
      return bench::DiagnoseCase{made.model, made.recordings};
    };
    options->bench.reveal = [](const std::string& folder, const std::string& verdict) {
      return opened(conceal::reveal(folder, verdict));
    };
    result = bench::bench_diagnose(options->bench);
  });
}

}  // namespace sanso::cli
