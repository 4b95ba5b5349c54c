#include <memory>
#include <string>
#include <vector>

#include "tools/diagnose/identify/identify.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {

void add_identify(CLI::App& app, int& result) {
  struct Options {
    std::string model, out;
    std::vector<std::string> recordings;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("identify", "fit friction, inertia, gain, delay and zero of every joint to recordings");
  command->add_option("--model", options->model, "model folder: robot.urdf and model.toml")->required();
  command->add_option("--recordings", options->recordings, "recordings (CSV, plain or gzip), one or more")->required();
  command->add_option("--out", options->out, "folder for the identified model")->required();
  command->footer(
      "Names no missing physics: see `sanso diagnose`.\n"
      "Example:\n  sanso identify --model my_robot --recordings walk_1.csv walk_2.csv --out my_robot_fitted");
  command->callback(
      [options, &result] { result = diagnose::run_identify(options->model, options->recordings, options->out); });
}

}  // namespace sanso::cli
