// `sanso diagnose`: the options of the command; work and exit code are those of
// tools/diagnose/run.
#include <filesystem>
#include <memory>
#include <vector>

#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/run/predict_effort.h"
#include "tools/diagnose/run/session_recordings.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {

void add_diagnose(CLI::App& app, int& result) {
  auto options = std::make_shared<diagnose::DiagnoseOptions>();
  auto predict = std::make_shared<std::string>("motion");
  CLI::App* command = app.add_subcommand(
      "diagnose", "find where simulation and recording part, and name the missing physics");
  auto sessions = std::make_shared<std::vector<std::filesystem::path>>();
  CLI::Option* const model =
      command->add_option("--model", options->model, "model folder: robot.urdf and model.toml");
  CLI::Option* const recordings = command->add_option(
      "--recordings", options->recordings,
      "recordings (CSV, plain or gzip; .mcap and .db3 of ros2 bag), one or more");
  command
      ->add_option("--session", *sessions,
                   "instead of both: folders of `sanso learn --out`, one or more; their trials "
                   "against the planner's model")
      ->excludes(model)
      ->excludes(recordings);
  command->add_option("--out", options->out, "folder for verdict.json, report.html and model/")
      ->required();
  command
      ->add_option("--predict", *predict,
                   "motion: simulate from the effort; effort: the motion is given, predict torque")
      ->check(CLI::IsMember({"motion", "effort"}))
      ->capture_default_str();
  command->add_flag("--free-gain", options->free_gain,
                    "with --predict effort: the scale of the recorded efforts is not known");
  command->add_option("--effects", options->effects, "only these ids of the library")
      ->delimiter(',');
  command->add_option("--without", options->without, "leave these ids out of the library")
      ->delimiter(',');
  command->add_option("--seed", options->seed, "seed of every random draw")->capture_default_str();
  command
      ->add_option("--horizon", options->settings.remains.horizon,
                   "how far ahead you predict, s: errors there say whether what is left matters")
      ->capture_default_str();
  command
      ->add_option("--matters", options->settings.remains.matters,
                   "errors there that you can live with, rad or m (N m with --predict effort)")
      ->capture_default_str();
  command
      ->add_option("--time-limit", options->time_limit,
                   "s, after which the run ends and writes what it found so far; 0: none")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_flag("--json", options->json, "print verdict.json");
  command->add_flag("--quiet", options->quiet, "no progress lines");
  command->footer(
      "Exit codes: 0 no mismatch, 1 mismatch found, 2 refused or ended early.\n"
      "Ctrl-C, SIGTERM and --time-limit write an UNFINISHED verdict of what was found so far.\n"
      "Example:\n  sanso diagnose "
      "--model my_robot --recordings walk_1.csv walk_2.csv --out result\n"
      "  sanso diagnose --predict effort --model my_arm --recordings run.csv --out friction\n"
      "  sanso diagnose --session runs/squat --out found");
  command->callback([options, predict, sessions, &result] {
    if (!sessions->empty())
      diagnose::use_sessions(*sessions, *options);
    else if (options->model.empty() || options->recordings.empty())
      throw CLI::RequiredError("--session or both --model and --recordings");
    result = *predict == "effort" ? diagnose::run_predict_effort(*options)
                                  : diagnose::run_diagnose(*options);
  });
}

}  // namespace sanso::cli
