// Ranks take jobs from one counter, so that long and short sessions even out.
#include "tools/sweep/sessions.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/app/interrupt.h"
#include "host/learn/wall_clock.h"
#include "shared/files/atomic_file.h"
#include "shared/files/json.h"

namespace sanso::sweep {
namespace {

using Json = nlohmann::ordered_json;

/// The row of a finished session, from what it stored.
Json row_of(const app::LearnOptions& job) {
  const Json summary = files::read_json<Json>(job.out / "summary.json");
  const Json& iterations = summary.at("iterations");
  int succeeded = 0, counted = 0;
  double best = iterations.front().at("cost"), first = best;
  for (const Json& i : iterations) {
    if (!i.at("failed").get<bool>()) best = std::min(best, i.at("cost").get<double>());
  }
  for (std::size_t i = iterations.size() > 10 ? iterations.size() - 10 : 0; i < iterations.size();
       ++i, ++counted) {
    if (iterations[i].at("succeeded").get<bool>()) ++succeeded;
  }
  return {{"motion", job.motion},
          {"world", job.world},
          {"seed", job.seed},
          {"trials", iterations.size()},
          {"first_cost", first},
          {"best_cost", best},
          {"last_cost", iterations.back().at("cost")},
          {"succeeded_of_last", succeeded},
          {"last", counted},
          {"digest", iterations.back().at("digest")}};
}

Json run_session(const app::LearnOptions& job, const app::RobotFactory& make_robot) {
  try {
    app::learn(job, make_robot);
    return row_of(job);
  } catch (const std::exception& error) {
    return {
        {"motion", job.motion}, {"world", job.world}, {"seed", job.seed}, {"error", error.what()}};
  }
}

/// The sessions that this rank takes, until none is left or a rank is asked to stop.
Json run_mine(Ranks& ranks, const std::vector<app::LearnOptions>& jobs,
              const app::RobotFactory& make_robot) {
  const auto count = static_cast<int>(jobs.size());
  Json rows = Json::array();
  for (int i = ranks.take_job(); i < count; i = ranks.take_job()) {
    Json row = run_session(jobs[static_cast<std::size_t>(i)], make_robot);
    row["job"] = i;
    fmt::print("[{}/{}] rank {} {}\n", i + 1, count, ranks.rank(), row.dump());
    std::fflush(stdout);
    rows.push_back(std::move(row));
    if (app::Interrupt::requested()) ranks.take_no_more();
  }
  return rows;
}

}  // namespace

std::vector<app::LearnOptions> sessions_of(const SessionsOptions& o) {
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

int run_sessions(Ranks& ranks, const SessionsOptions& options,
                 const app::RobotFactory& make_robot) {
  const app::Interrupt interrupt;
  const std::vector<app::LearnOptions> jobs = sessions_of(options);
  const double begin = learn::wall_s();
  std::vector<Json> rows;
  for (const std::string& part : ranks.gather(run_mine(ranks, jobs, make_robot).dump()))
    for (const Json& row : Json::parse(part)) rows.push_back(row);
  const bool stopped = ranks.any(app::Interrupt::requested());
  if (ranks.rank() != 0) return 0;
  std::sort(rows.begin(), rows.end(),
            [](const Json& a, const Json& b) { return a.at("job") < b.at("job"); });
  const auto answered = std::count_if(rows.begin(), rows.end(),
                                      [](const Json& row) { return !row.contains("error"); });
  const std::filesystem::path file = options.out / "sweep.json";
  const Json all{{"ranks", ranks.size()}, {"wall_s", learn::wall_s() - begin}, {"sessions", rows}};
  files::write_atomically(file, all.dump(2) + '\n');
  fmt::print("{} of {} sessions on {} ranks in {:.1f} s: {}{}\n", answered, jobs.size(),
             ranks.size(), learn::wall_s() - begin, file.string(),
             stopped ? "; stopped, the same command goes on" : "");
  return answered == static_cast<std::ptrdiff_t>(jobs.size()) ? 0 : 2;
}

}  // namespace sanso::sweep
