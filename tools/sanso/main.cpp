// The command line `sanso`, and the small one of tools/demo: whatever commands are linked; no logic
// of its own.
#include <fmt/format.h>

#include <exception>

#include "tools/sanso/commands.h"

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
  sanso::cli::add_commands(app, result);
  try {
    app.parse(argc, argv);
    if (app.get_subcommands().empty()) fmt::print("{}", sanso::cli::kNext);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? sanso::cli::kDone : sanso::cli::kCouldNot;
  } catch (const std::exception& error) {
    fmt::print(stderr, "sanso: {}\n", error.what());
    return sanso::cli::kCouldNot;
  }
  return result;
}
