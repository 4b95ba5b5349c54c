#include "tools/sweep/identification.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <vector>

#include "host/app/interrupt.h"
#include "host/learn/episode.h"
#include "host/motion/motion.h"

namespace sanso::sweep {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

double wall_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

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

learn::ParameterMap parameters() { return learn::ParameterMap(model::nominal_parameters()); }

}  // namespace

learn::Identification identify_over(const Ranks& ranks, const IdentificationOptions& options) {
  const app::Interrupt interrupt;
  learn::IdentifySettings settings;
  settings.search.population = options.population;
  settings.search.generations = options.generations;
  const auto go_on = [&](const learn::CrossEntropyState&) { return !ranks.any(app::Interrupt::requested()); };
  return learn::identify(windows_of_session(options.session), parameters(), model::make_plane(),
                         motion::MotionLibrary().load(options.motion).weights.state, settings, options.seed, {}, go_on,
                         ranks.shared_candidates());
}

int run_identification(const Ranks& ranks, const IdentificationOptions& options) {
  const double begin = wall_s();
  const learn::Identification found = identify_over(ranks, options);
  const bool complete = found.generations >= options.generations;
  if (ranks.rank() != 0) return complete ? 0 : 2;
  const learn::ParameterMap map = parameters();
  Json deviations;
  for (Eigen::Index i = 0; i < map.size(); ++i) deviations[map.names()[static_cast<std::size_t>(i)]] = found.z[i];
  const Json answer{{"ranks", ranks.size()},
                    {"wall_s", wall_s() - begin},
                    {"bytes_per_generation", 8 * options.population},
                    {"generations", found.generations},
                    {"loss_initial", found.loss_initial},
                    {"loss", found.loss},
                    {"prior_deviations", deviations}};
  fmt::print("{}\n", answer.dump(2));
  return complete ? 0 : 2;
}

}  // namespace sanso::sweep
