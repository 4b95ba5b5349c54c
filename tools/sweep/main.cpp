// sanso-sweep: many learning sessions, one identification, or a campaign of pushes, spread over MPI ranks. Same results as
// on one rank.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/app/learn_command.h"
#include "host/motion/motion.h"
#include "tools/inprocess/inprocess_access.h"
#include "tools/sweep/predictions.h"
#include "tools/sweep/pushes.h"
#include "tools/sweep/ranks.h"

namespace sanso::sweep {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double wall_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

struct SweepOptions {
  std::vector<std::string> motions{"stand", "squat"}, worlds{"lab"};
  std::vector<std::uint64_t> seeds{1};
  std::vector<std::string> without;
  int iterations = 10, threads = 1;
  fs::path out;
};

std::vector<app::LearnOptions> jobs_of(const SweepOptions& o) {
  std::vector<app::LearnOptions> jobs;
  for (const std::string& motion : o.motions)
    for (const std::string& world : o.worlds)
      for (const std::uint64_t seed : o.seeds) {
        app::LearnOptions job;
        job.motion = motion;
        job.world = world;
        job.seed = seed;
        job.iterations = o.iterations;
        job.threads = o.threads;
        job.without = o.without;
        job.resume = true;  // a sweep that was stopped goes on where it was
        job.quiet = true;
        std::string folder = fmt::format("{}_{}_seed{}", motion, world, seed);
        std::replace(folder.begin(), folder.end(), ':', '-');
        job.out = o.out / folder;
        jobs.push_back(job);
      }
  return jobs;
}

// The row of a finished session, from what it stored.
Json row_of(const app::LearnOptions& job) {
  std::ifstream file(job.out / "summary.json");
  const Json summary = Json::parse(file);
  const Json& iterations = summary.at("iterations");
  int succeeded = 0, counted = 0;
  double best = iterations.front().at("cost"), first = best;
  for (const Json& i : iterations) {
    if (!i.at("failed").get<bool>()) best = std::min(best, i.at("cost").get<double>());
  }
  for (std::size_t i = iterations.size() > 10 ? iterations.size() - 10 : 0; i < iterations.size(); ++i, ++counted) {
    if (iterations[i].at("succeeded").get<bool>()) ++succeeded;
  }
  return {{"motion", job.motion}, {"world", job.world}, {"seed", job.seed}, {"trials", iterations.size()}, {"first_cost", first},
          {"best_cost", best}, {"last_cost", iterations.back().at("cost")}, {"succeeded_of_last", succeeded}, {"last", counted},
          {"digest", iterations.back().at("digest")}};
}

int run_sweep(Ranks& ranks, const SweepOptions& options) {
  const std::vector<app::LearnOptions> jobs = jobs_of(options);
  const double begin = wall_s();
  const auto in_process = [](const app::LearnOptions& o) { return std::make_unique<inprocess::InProcessAccess>(o.world); };
  Json mine = Json::array();
  for (int i = ranks.take_job(); i < static_cast<int>(jobs.size()); i = ranks.take_job()) {
    const app::LearnOptions& job = jobs[static_cast<std::size_t>(i)];
    Json row;
    try {
      app::learn(job, in_process);
      row = row_of(job);
    } catch (const std::exception& error) {
      row = {{"motion", job.motion}, {"world", job.world}, {"seed", job.seed}, {"error", error.what()}};
    }
    row["job"] = i;
    mine.push_back(row);
    fmt::print("[{}/{}] rank {} {}\n", i + 1, jobs.size(), ranks.rank(), row.dump());
    std::fflush(stdout);
  }
  std::vector<Json> rows;
  for (const std::string& part : ranks.gather(mine.dump()))
    for (const Json& row : Json::parse(part)) rows.push_back(row);
  if (ranks.rank() != 0) return 0;
  std::sort(rows.begin(), rows.end(), [](const Json& a, const Json& b) { return a.at("job") < b.at("job"); });
  const bool all_answered = std::none_of(rows.begin(), rows.end(), [](const Json& row) { return row.contains("error"); });
  std::ofstream(options.out / "sweep.json") << Json{{"ranks", ranks.size()}, {"wall_s", wall_s() - begin}, {"sessions", rows}}.dump(2) << '\n';
  fmt::print("{} sessions on {} ranks in {:.1f} s: {}\n", rows.size(), ranks.size(), wall_s() - begin, (options.out / "sweep.json").string());
  return all_answered ? 0 : 2;
}

struct IdentifyOptions {
  fs::path session;
  std::string motion = "squat";
  std::uint64_t seed = 1;
  int population = 64, generations = 15;
};

std::vector<learn::PredictionWindow> windows_of_session(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".episode") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<learn::PredictionWindow> windows;
  for (const fs::path& file : files)
    for (const auto& w : learn::windows_of(learn::load_episode(file))) windows.push_back(w);
  return windows;
}

int run_identify(Ranks& ranks, const IdentifyOptions& options) {
  const auto windows = windows_of_session(options.session);
  const learn::ParameterMap map(model::nominal_parameters());
  learn::IdentifySettings settings;
  settings.search.population = options.population;
  settings.search.generations = options.generations;
  const double begin = wall_s();
  const auto found = learn::identify(windows, map, model::make_plane(), motion::MotionLibrary().load(options.motion).weights.state,
                                     settings, options.seed, {}, {}, ranks.shared_candidates());
  if (ranks.rank() != 0) return 0;
  Json parameters;
  for (Eigen::Index i = 0; i < map.size(); ++i) parameters[map.names()[static_cast<std::size_t>(i)]] = found.z[i];
  fmt::print("{}\n", Json{{"ranks", ranks.size()}, {"wall_s", wall_s() - begin}, {"bytes_per_generation", 8 * options.population},
                          {"loss_initial", found.loss_initial}, {"loss", found.loss}, {"prior_deviations", parameters}}.dump(2));
  return 0;
}

int run(int argc, char** argv) {
  Ranks ranks(&argc, &argv);
  CLI::App app("learning sessions or one identification, spread over MPI ranks", "sanso-sweep");
  app.require_subcommand(1);
  app.footer("Examples:\n"
             "  mpirun -n 2 sanso-sweep learn --motions stand,squat --worlds lab,hard --seeds 1,2 --iterations 20 --out runs/sweep\n"
             "  mpirun -n 2 sanso-sweep identify --session runs/sweep/squat_lab_seed1\n"
             "  mpirun -n 2 sanso-sweep pushes --session runs/sweep/squat_lab_seed1 --motion squat --out runs/pushes");
  SweepOptions sweep;
  CLI::App* learn = app.add_subcommand("learn", "every combination of motions, worlds and seeds as a session of its own");
  learn->add_option("--motions", sweep.motions, "names of motions")->delimiter(',')->capture_default_str();
  learn->add_option("--worlds", sweep.worlds, "of the emulated robot")->delimiter(',')->capture_default_str();
  learn->add_option("--seeds", sweep.seeds, "one session each")->delimiter(',')->capture_default_str();
  learn->add_option("--without", sweep.without, "layers switched off, as in sanso learn")->delimiter(',');
  learn->add_option("--iterations", sweep.iterations, "trials of every session")->capture_default_str()->check(CLI::PositiveNumber);
  learn->add_option("--threads", sweep.threads, "of every rank's planner")->capture_default_str()->check(CLI::PositiveNumber);
  learn->add_option("--out", sweep.out, "folder of the sessions and of sweep.json")->required();
  IdentifyOptions identify;
  CLI::App* id = app.add_subcommand("identify", "parameters of the model from the episodes of a session");
  id->add_option("--session", identify.session, "folder of a learning session")->required()->check(CLI::ExistingDirectory);
  id->add_option("--motion", identify.motion, "whose weights the loss uses")->capture_default_str();
  id->add_option("--seed", identify.seed)->capture_default_str();
  id->add_option("--population", identify.population)->capture_default_str()->check(CLI::Range(4, 100000));
  id->add_option("--generations", identify.generations)->capture_default_str()->check(CLI::PositiveNumber);
  PredictionOptions predictions;
  CLI::App* predict = app.add_subcommand("predict", "what the models of sessions foresee over 0.72 s beside a recorded trial");
  predict->add_option("--episode", predictions.episode, "trial_NNNN.episode of a session")->required()->check(CLI::ExistingFile);
  predict->add_option("--sessions", predictions.sessions, "folders whose newest models predict it")->required()->delimiter(',');
  predict->add_option("--motion", predictions.motion, "whose weights the loss uses")->capture_default_str();
  predict->add_option("--out", predictions.out, "folder of predictions.json")->required();
  PushOptions pushes;
  pushes.without = {"none", "lower", "middle", "upper"};
  CLI::App* push = app.add_subcommand("pushes", "push the torso while a learned motion runs; who stays on its feet");
  push->add_option("--session", pushes.session, "folder of a learning session")->required()->check(CLI::ExistingDirectory);
  push->add_option("--motion", pushes.motion, "of that session")->capture_default_str();
  push->add_option("--world", pushes.world, "of the emulated robot")->capture_default_str();
  push->add_option("--without", pushes.without, "one campaign each: none, lower, middle, upper")->delimiter(',')->capture_default_str();
  push->add_option("--count", pushes.count, "pushes of every campaign")->capture_default_str()->check(CLI::PositiveNumber);
  push->add_option("--largest", pushes.largest_Ns, "impulses are drawn from 0 to this [N s]")->capture_default_str()->check(CLI::PositiveNumber);
  push->add_option("--seed", pushes.seed, "of the pushes and of the sensor noise")->capture_default_str();
  push->add_option("--out", pushes.out, "folder of pushes.json")->required();
  try {
    app.parse(argc, argv);
    if (*learn) fs::create_directories(sweep.out);
    if (*predict) {
      fs::create_directories(predictions.out);
      return run_predictions(predictions);
    }
    if (*push) {
      fs::create_directories(pushes.out);
      return run_pushes(ranks, pushes);
    }
    return *learn ? run_sweep(ranks, sweep) : run_identify(ranks, identify);
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
