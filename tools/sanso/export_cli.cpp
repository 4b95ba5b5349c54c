// `sanso export`: stored trials and model folders as files of other programs.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <stdexcept>

#include "shared/files/atomic_file.h"
#include "tools/diagnose/formats/formats.h"
#include "tools/export/op3_urdf.h"
#include "tools/export/trial_mcap.h"
#include "tools/sanso/commands.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  fs::path folder, out, models;
  int trial = 0;  // 0: the last one stored
  bool urdf = false, mjcf = false, sdf = false;
};

fs::path episode_file(const fs::path& folder, int trial) {
  return learn::trial_file(folder, static_cast<std::uint32_t>(trial - 1));
}

int last_trial(const fs::path& folder) {
  int trial = 0;
  while (fs::exists(episode_file(folder, trial + 1))) ++trial;
  if (trial == 0)
    throw std::runtime_error(folder.string() +
                             ": holds no trial; expected the folder that `sanso learn --out` or "
                             "`sanso demo --out` wrote");
  return trial;
}

void write_model(const diagnose::Exported& made, const fs::path& file) {
  files::write_atomically(file, made.text);
  fmt::print("{}\n", file.string());
  for (const std::string& lost : made.lost) fmt::print("  not in it: {}\n", lost);
}

int export_model(const ExportOptions& options) {
  const diagnose::ModelFolder model = diagnose::read_model_folder(options.folder.string());
  if (!options.urdf && !options.mjcf && !options.sdf)
    throw std::runtime_error(options.folder.string() +
                             ": a model folder; say as what: --urdf, --mjcf, --sdf");
  if (options.trial > 0 || options.out.extension() == ".mcap")
    throw std::runtime_error(options.folder.string() +
                             ": a model folder, which holds no trials; --trial and --mcap belong "
                             "to the folder of a session");
  const fs::path folder = options.models.empty() ? options.folder / "export" : options.models;
  fs::create_directories(folder);
  const fs::path stem = folder / model.tree.name;
  if (options.mjcf) write_model(diagnose::mjcf_of(model), stem.string() + ".xml");
  if (options.urdf) write_model(diagnose::urdf_of(model), stem.string() + ".urdf");
  if (options.sdf) write_model(diagnose::sdf_of(model), stem.string() + ".sdf");
  return kDone;
}

int run_export(const ExportOptions& options) {
  if (fs::exists(options.folder / "model.toml")) return export_model(options);
  if (options.mjcf || options.sdf)
    throw std::runtime_error("--mjcf and --sdf need a model folder (docs/model-folder.md); " +
                             options.folder.string() + " holds no model.toml");
  const int last = last_trial(options.folder), trial = options.trial > 0 ? options.trial : last;
  const fs::path stored = episode_file(options.folder, trial);
  if (!fs::exists(stored))
    throw std::runtime_error(
        fmt::format("--trial {}: {} has trials 1 to {}", trial, options.folder.string(), last));
  fs::path out = options.out;
  if (out.empty()) out = options.folder / fmt::format("trial_{:04d}.mcap", trial);
  const std::uint64_t messages = exports::write_trial_mcap(learn::load_episode(stored), out);
  fmt::print("trial {}: {} messages in {}\n", trial, messages, out.string());
  if (options.urdf) {
    fs::path urdf = out;
    urdf.replace_extension(".urdf");
    files::write_atomically(urdf, exports::op3_urdf());
    fmt::print("robot: {}\n", urdf.string());
  }
  return kDone;
}

}  // namespace

void add_export(CLI::App& app, int& result) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand(
      "export",
      "a stored trial as an MCAP file, for Foxglove, PlotJuggler and ros2 bag; a model folder as "
      "URDF, MJCF, SDF");
  command
      ->add_option("DIR", options->folder,
                   "folder that `sanso learn` or `sanso demo` wrote, or a model folder")
      ->required();
  command->add_option("--trial", options->trial, "number of the trial, from 1; the last one")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--mcap", options->out, "the file to write; DIR/trial_NNNN.mcap");
  command->add_flag("--urdf", options->urdf,
                    "the model as URDF; of a session, also the robot, beside the trial");
  command->add_flag("--mjcf", options->mjcf, "the model as MuJoCo's MJCF, with its actuators");
  command->add_flag("--sdf", options->sdf, "the model as SDF");
  command->add_option("--out", options->models, "folder for the model's files; DIR/export");
  command->footer(
      "Examples:\n  sanso export runs/squat\n"
      "  sanso export runs/squat --trial 1 --mcap first.mcap\n"
      "  sanso export diagnosis/patched_model --mjcf --sdf");
  command->callback([options, &result] { result = run_export(*options); });
}

}  // namespace sanso::cli
