// `sanso report`: the report of a session's folder, several of them side by side, figures alone, or
// a film.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "shared/files/atomic_file.h"
#include "tools/sanso/commands.h"
#include "tools/sanso/film.h"
#include "tools/session_report/session_report.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  fs::path folder;
  std::vector<fs::path> compare;
  fs::path figures;
  fs::path film, browser;
  std::vector<int> trials;
  report::FilmOptions how;
};

int run_film(ReportOptions options) {
  options.how.kind = film_kind(options.film);
  if (!options.trials.empty()) {
    options.how.first = options.trials.front();
    options.how.second = options.trials.back();
  }
  make_film(options.folder, options.how, options.browser, options.film);
  fmt::print("film: {} ({:.0f} kB)\n", options.film.string(),
             1e-3 * static_cast<double>(fs::file_size(options.film)));
  return kDone;
}

int run_report(const ReportOptions& options) {
  if (!options.film.empty()) return run_film(options);
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
  command->add_option("--film", options->film,
                      "instead: two trials as a film (FILE.webm, FILE.gif) or moments of them as a "
                      "picture (FILE.png), drawn by chromium without a display");
  command->add_option("--trials", options->trials, "of the film, above and below; first and last")
      ->expected(2)
      ->check(CLI::Range(1, 1000000));
  command->add_option("--width", options->how.width_px, "of the film, pixels")
      ->capture_default_str()
      ->check(CLI::Range(160, 3840));
  command->add_option("--height", options->how.row_height_px, "of each trial in it, pixels")
      ->capture_default_str()
      ->check(CLI::Range(120, 2160));
  command->add_option("--fps", options->how.fps, "pictures a second")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 60.0));
  command->add_option("--from", options->how.from_s, "second of the trial at which it begins")
      ->check(CLI::Range(0.0, 1000.0));
  command->add_option("--to", options->how.to_s, "at which it ends")
      ->check(CLI::Range(0.0, 1000.0));
  command->add_option("--browser", options->browser,
                      "the chromium that draws; the one on the PATH");
  command->footer(
      "Examples:\n  sanso report results/squat\n"
      "  sanso report results/squat --film squat.webm --trials 1 100\n"
      "  sanso report results/squat --compare results/no_middle results/no_upper");
  command->callback([options, &result] { result = run_report(*options); });
}

}  // namespace sanso::cli
