// `sanso identify`: two commands under one name, the whole-body model from episodes or any
// robot's settings from recordings.
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/app/identify_command.h"
#include "tools/diagnose/run/identify.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {
namespace {

struct Options {
  std::string model;
  std::vector<std::string> recordings;
  app::IdentifyOptions whole_body;
};

constexpr char kFooter[] =
    "Two kinds of recordings:\n"
    "  --model and --recordings   any robot on a fixed base, a URDF and CSV files: friction, "
    "inertia, gain, delay and "
    "zero of\n"
    "                             every joint by multiple shooting. Names no missing physics: see "
    "`sanso diagnose`.\n"
    "  --episodes                 trials of the OP3 (sanso learn): masses, centre of mass, "
    "inertias, servos and ground "
    "friction of\n"
    "                             the whole-body model by the cross-entropy method; the newest "
    "fifth of the trials "
    "judges.\n"
    "                             The search in --out is kept after every generation: Ctrl-C, "
    "then --resume.\n"
    "Examples:\n"
    "  sanso identify --model my_robot --recordings walk_1.csv walk_2.csv --out my_robot_fitted\n"
    "  sanso identify --episodes runs/squat --out runs/squat_model\n"
    "  sanso identify --episodes runs/squat runs/walk --motion squat --generations 60 --out "
    "runs/both --resume";

void add_whole_body(CLI::App& command, app::IdentifyOptions& o) {
  command
      .add_option("--episodes", o.episodes, "folders of sessions or .episode files, one or more")
      ->check(CLI::ExistingPath);
  command
      .add_option("--motion", o.motion,
                  "with --episodes: whose weights the loss uses; by default the session's own")
      ->needs("--episodes");
  command.add_option("--seed", o.seed, "with --episodes; same seed, same bits")
      ->capture_default_str();
  command.add_option("--population", o.population, "with --episodes: candidates a generation")
      ->capture_default_str()
      ->check(CLI::Range(4, 100000));
  command
      .add_option("--generations", o.generations,
                  "with --episodes: in all, including those of a resumed search")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  command.add_option("--threads", o.threads, "with --episodes; any number gives the same bits")
      ->capture_default_str()
      ->check(CLI::Range(1, 256));
  command.add_flag("--resume", o.resume, "with --episodes: go on with the search in --out")
      ->needs("--episodes");
}

int run(const Options& options) {
  if (!options.whole_body.episodes.empty()) return app::identify(options.whole_body);
  if (options.model.empty() || options.recordings.empty())
    throw std::runtime_error(
        "identify: give --model and --recordings (a robot on a fixed base), or --episodes (trials "
        "of the OP3)");
  return diagnose::run_identify(options.model, options.recordings, options.whole_body.out.string());
}

}  // namespace

void add_identify(CLI::App& app, int& result) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("identify", "fit a model's parameters to recordings");
  CLI::Option* model =
      command->add_option("--model", options->model, "model folder: robot.urdf and model.toml");
  CLI::Option* recordings = command->add_option("--recordings", options->recordings,
                                                "recordings (CSV, plain or gzip), one or more");
  add_whole_body(*command, options->whole_body);
  command->get_option("--episodes")->excludes(model)->excludes(recordings);
  command->add_option("--out", options->whole_body.out, "folder for the identified model")
      ->required();
  command->footer(kFooter);
  command->callback([options, &result] { result = run(*options); });
}

}  // namespace sanso::cli
