// The command line `sanso`: joins the commands of all folders; no logic of its own.
#include <fmt/format.h>

#include <exception>

#include "tools/sanso/commands.h"

namespace {

constexpr char kNext[] =
    R"(sanso: lets a humanoid learn to move, and finds what a simulation leaves out. What next?

  see a robot learn to squat, live      sanso demo --open
  learn a motion, and its report        sanso learn --motion walk --iterations 100 --out runs/walk
  which motions there are               sanso motions
  see a controller's robot              sanso watch HOST:PORT --key FILE
  what your simulation leaves out       sanso diagnose --help
  everything else                       sanso --help
)";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "sanso: three-layer whole-body control that learns its robot, and diagnosis of simulation "
      "against recording",
      "sanso");
  app.require_subcommand(0, 1);
  app.footer(
      "Examples and more: sanso COMMAND --help.\nExit codes: 0 done, 1 the answer is \"bad\", 2 "
      "could not answer.");
  int result = sanso::cli::kDone;
  sanso::cli::add_demo(app, result);
  sanso::cli::add_bench(app, result);
  sanso::cli::add_conceal(app, result);
  sanso::cli::add_learn(app, result);
  sanso::cli::add_motions(app, result);
  sanso::cli::add_report(app, result);
  sanso::cli::add_reveal(app, result);
  sanso::cli::add_export(app, result);
  sanso::cli::add_import(app, result);
  sanso::cli::add_watch(app, result);
  sanso::cli::add_identify(app, result);
  sanso::cli::add_score(app, result);
  sanso::cli::add_diagnose(app, result);
  sanso::cli::add_bench_diagnose(app, result);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) fmt::print("{}", kNext);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? sanso::cli::kDone : sanso::cli::kCouldNot;
  } catch (const std::exception& error) {
    fmt::print(stderr, "sanso: {}\n", error.what());
    return sanso::cli::kCouldNot;
  }
  return result;
}
