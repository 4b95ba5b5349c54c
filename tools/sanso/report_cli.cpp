// `sanso report`: the report of a session's folder, several of them side by side, or figures
// alone.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "shared/files/atomic_file.h"
#include "tools/sanso/commands.h"
#include "tools/session_report/session_report.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  fs::path folder;
  std::vector<fs::path> compare;
  fs::path figures;
};

int run_report(const ReportOptions& options) {
  if (!options.compare.empty()) {
    std::vector<fs::path> all{options.folder};
    all.insert(all.end(), options.compare.begin(), options.compare.end());
    const fs::path file = options.folder / "compare.svg";
    files::write_atomically(file, report::compare_costs(all));
    fmt::print("figure: {}\n", file.string());
    return kDone;
  }
  fmt::print("{}", report::session_table(options.folder));
  if (!options.figures.empty()) report::write_session_figures(options.folder, options.figures);
  fmt::print("report: {}\n", report::write_session_report(options.folder).string());
  return kDone;
}

}  // namespace

void add_report(CLI::App& app, int& result) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command =
      app.add_subcommand("report", "write report.html of a learning session and print its table");
  command->add_option("DIR", options->folder, "folder that `sanso learn` or `sanso demo` wrote")
      ->required();
  command->add_option("--compare", options->compare,
                      "further sessions: their costs in one figure, DIR/compare.svg");
  command->add_option("--figures", options->figures,
                      "also write the figures over trials as SVG files into this folder");
  command->footer(
      "Examples:\n  sanso report results/squat\n"
      "  sanso report results/squat --compare results/no_middle results/no_upper");
  command->callback([options, &result] { result = run_report(*options); });
}

}  // namespace sanso::cli
