// `sanso score`: the options of the command; the work is in tools/diagnose/run.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "shared/files/input_error.h"
#include "tools/diagnose/run/score.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {

void add_score(CLI::App& app, int& result) {
  struct Options {
    std::string model;
    std::vector<std::string> recordings;
    bool json = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("score", "how far a model's prediction is from recordings");
  command->add_option("--model", options->model, "model folder: robot.urdf and model.toml")
      ->required();
  command
      ->add_option("--recordings", options->recordings, "recordings (.csv, .csv.gz, .mcap, .db3)")
      ->required();
  command->add_flag("--json", options->json, "RMSE by recording, horizon and channel as JSON");
  command->footer(
      "Example:\n  sanso score --model tools/diagnose/examples/emps --recordings DATA_EMPS.csv");
  command->callback([options, &result] {
    try {
      const auto scores = diagnose::score_files(options->model, options->recordings);
      fmt::print("{}",
                 options->json ? diagnose::score_json(scores) : diagnose::score_table(scores));
      result = kDone;
    } catch (const files::InputError& e) {
      fmt::print(stderr, "sanso score: {}\n", e.what());
      result = kCouldNot;
    }
  });
}

}  // namespace sanso::cli
