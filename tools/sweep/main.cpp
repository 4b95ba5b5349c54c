// sanso-sweep: many learning sessions, one identification, or a campaign of pushes, spread over MPI
// ranks. Same results as on one rank.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <filesystem>
#include <memory>

#include "tools/inprocess/inprocess_access.h"
#include "tools/sweep/identification.h"
#include "tools/sweep/predictions.h"
#include "tools/sweep/pushes.h"
#include "tools/sweep/ranks.h"
#include "tools/sweep/sessions.h"

namespace sanso::sweep {
namespace {

namespace fs = std::filesystem;

constexpr char kFooter[] = R"(Examples:
  mpirun -n 2 sanso-sweep learn --motions stand,squat --worlds lab,hard --seeds 1,2 \
      --iterations 20 --out runs/sweep
  mpirun -n 2 sanso-sweep identify --episodes runs/sweep/squat_lab_seed1
  mpirun -n 2 sanso-sweep pushes --session runs/sweep/squat_lab_seed1 --motion squat \
      --out runs/pushes
SIGINT or SIGTERM to one rank ends the sweep after the trials under way; sessions go on with the
same command. A stopped mpirun kills its ranks a second later, or after S seconds
with --mca odls_base_sigkill_timeout S.)";

CLI::App* add_learn(CLI::App& app, SessionsOptions& o) {
  CLI::App* c = app.add_subcommand(
      "learn", "every combination of motions, worlds and seeds as a session of its own");
  c->add_option("--motions", o.motions, "names of motions")->delimiter(',')->capture_default_str();
  c->add_option("--worlds", o.worlds, "of the emulated robot")
      ->delimiter(',')
      ->capture_default_str();
  c->add_option("--seeds", o.seeds, "one session each")->delimiter(',')->capture_default_str();
  c->add_option("--without", o.without, "layers switched off, as in sanso learn")->delimiter(',');
  c->add_option("--iterations", o.iterations, "trials of every session")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  c->add_option("--threads", o.threads, "of every rank's planner")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  c->add_option("--out", o.out, "folder of the sessions and of sweep.json")->required();
  return c;
}

CLI::App* add_identify(CLI::App& app, app::IdentifyOptions& o) {
  CLI::App* c = app.add_subcommand(
      "identify", "parameters of the model from the trials of sessions (sanso identify)");
  c->add_option("--episodes", o.episodes, "folders of learning sessions")
      ->required()
      ->check(CLI::ExistingPath);
  c->add_option("--motion", o.motion, "whose weights the loss uses; by default the session's own");
  c->add_option("--seed", o.seed)->capture_default_str();
  c->add_option("--population", o.population)->capture_default_str()->check(CLI::Range(4, 100000));
  c->add_option("--generations", o.generations)->capture_default_str()->check(CLI::PositiveNumber);
  c->add_option("--out", o.out, "folder that keeps the search's state after every generation");
  c->add_flag("--resume", o.resume, "go on with the search in --out")->needs("--out");
  return c;
}

CLI::App* add_predict(CLI::App& app, PredictionOptions& o) {
  CLI::App* c = app.add_subcommand(
      "predict", "what the models of sessions foresee over 0.72 s beside a recorded trial");
  c->add_option("--episode", o.episode, "trial_NNNN.episode of a session")
      ->required()
      ->check(CLI::ExistingFile);
  c->add_option("--sessions", o.sessions, "folders whose newest models predict it")
      ->required()
      ->delimiter(',');
  c->add_option("--motion", o.motion, "whose weights the loss uses")->capture_default_str();
  c->add_option("--out", o.out, "folder of predictions.json")->required();
  return c;
}

CLI::App* add_pushes(CLI::App& app, PushOptions& o) {
  CLI::App* c = app.add_subcommand(
      "pushes", "push the torso while a learned motion runs; who stays on its feet");
  c->add_option("--session", o.session, "folder of a learning session")
      ->required()
      ->check(CLI::ExistingDirectory);
  c->add_option("--motion", o.motion, "of that session")->capture_default_str();
  c->add_option("--world", o.world, "of the emulated robot")->capture_default_str();
  c->add_option("--without", o.without, "one campaign each: none, lower, middle, upper")
      ->delimiter(',')
      ->capture_default_str();
  c->add_option("--count", o.count, "pushes of every campaign")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  c->add_option("--smallest", o.smallest_Ns, "impulses are drawn from this [N s]")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  c->add_option("--largest", o.largest_Ns, "to this")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  c->add_option("--set", o.changes, "NAME=VALUE of planner and trial, as in sanso learn");
  c->add_option("--seed", o.seed, "of the pushes and of the sensor noise")->capture_default_str();
  c->add_option("--out", o.out, "folder of pushes.json")->required();
  return c;
}

int run(int argc, char** argv) {
  const Mpi mpi(&argc, &argv);
  Ranks ranks;
  CLI::App app("learning sessions or one identification, spread over MPI ranks", "sanso-sweep");
  app.require_subcommand(1);
  app.footer(kFooter);
  SessionsOptions sessions;
  app::IdentifyOptions identification;
  PredictionOptions predictions;
  PushOptions pushes;
  pushes.without = {"none", "lower", "middle", "upper"};
  const CLI::App* learn = add_learn(app, sessions);
  add_identify(app, identification);
  const CLI::App* predict = add_predict(app, predictions);
  const CLI::App* push = add_pushes(app, pushes);
  try {
    app.parse(argc, argv);
    for (const fs::path& out : {sessions.out, identification.out, predictions.out, pushes.out})
      if (!out.empty()) fs::create_directories(out);
    if (*learn) return run_sessions(ranks, sessions, inprocess::access_for);
    if (*predict) return run_predictions(predictions);
    if (*push) return run_pushes(ranks, pushes);
    return run_identification(ranks, identification);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "sanso-sweep: {}\n", error.what());
    return 2;
  }
}

}  // namespace
}  // namespace sanso::sweep

int main(int argc, char** argv) { return sanso::sweep::run(argc, argv); }
