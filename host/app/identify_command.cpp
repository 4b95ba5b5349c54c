// Reads the episodes, runs the search with its state in the output folder, writes losses and
// model; a stopped search continues.
#include "host/app/identify_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "host/app/interrupt.h"
#include "host/learn/episodes/episode.h"
#include "host/learn/model/identification_store.h"
#include "host/learn/model/residual_training.h"
#include "host/learn/seeds.h"
#include "host/learn/session/progress.h"
#include "host/motion/motion.h"
#include "shared/files/atomic_file.h"
#include "shared/files/hash.h"
#include "shared/files/json.h"
#include "shared/model/ground.h"

namespace sanso::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kHeldOut = 0.2;

fs::path state_file(const fs::path& out) { return out / "search.state"; }

std::vector<fs::path> episodes_in(const fs::path& given) {
  if (!fs::exists(given)) throw std::runtime_error(given.string() + ": no such folder or file");
  if (!fs::is_directory(given)) return {given};
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(given))
    if (entry.path().extension() == ".episode") files.push_back(entry.path());
  if (files.empty())
    throw std::runtime_error(
        given.string() +
        ": no trial_NNNN.episode in it; name the folder of a session (sanso learn --out)");
  std::sort(files.begin(), files.end());
  return files;
}

std::string motion_of(const IdentifyOptions& options) {
  if (!options.motion.empty()) return options.motion;
  const fs::path summary = options.episodes.front() / "summary.json";
  const Json read = files::json_or_null<Json>(summary);
  if (!read.is_object() || !read.contains("motion") || !read["motion"].is_string())
    throw std::runtime_error(summary.string() +
                             ": does not say which motion it is; name it with --motion");
  return read["motion"];
}

// The newest of a folder's trials are held out. A single file is for training.
void add_folder(const fs::path& given, IdentificationData& data) {
  const std::vector<fs::path> files = episodes_in(given);
  const std::size_t held = files.size() < 2 ? 0 : learn::newest_heldout(files.size(), kHeldOut);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const learn::Episode episode = learn::load_episode(files[i]);
    data.fingerprint = learn::mixed(data.fingerprint ^ learn::digest(episode));
    auto& part = i + held < files.size() ? data.train : data.heldout;
    for (const learn::PredictionWindow& w : learn::upright_windows_of(episode)) part.push_back(w);
  }
}

learn::ParameterMap parameter_map() { return learn::ParameterMap(model::nominal_parameters()); }

void mix(std::uint64_t& fingerprint, const std::string& text) {
  for (const char c : text) fingerprint = learn::mixed(fingerprint ^ static_cast<std::uint64_t>(c));
}

learn::IdentifySettings settings_of(const IdentifyOptions& options) {
  learn::IdentifySettings s;
  s.search.population = options.population;
  s.search.elites = std::max(2, options.population / 5);
  s.search.generations = options.generations;
  s.threads = options.threads;
  return s;
}

void prepare_folder(const IdentifyOptions& options) {
  if (options.out.empty()) return;
  fs::create_directories(options.out);
  if (fs::exists(state_file(options.out)) && !options.resume)
    throw std::runtime_error(
        options.out.string() +
        ": holds a search already; continue it with --resume or name another folder");
}

double loss_on(const std::vector<learn::PredictionWindow>& windows,
               const model::ModelParameters& theta, const model::Tangent& weights) {
  return learn::n_step_loss(windows, model::make_step_model(theta), model::make_plane(), weights);
}

Json losses_json(const IdentificationData& data, const learn::Identification& found) {
  Json j{{"training_windows", data.train.size()},
         {"training_initial", found.loss_initial},
         {"training", found.loss},
         {"heldout_windows", data.heldout.size()},
         {"heldout_initial", nullptr},
         {"heldout", nullptr}};
  if (!data.heldout.empty()) {
    j["heldout_initial"] = loss_on(data.heldout, model::nominal_parameters(), data.weights);
    j["heldout"] = loss_on(data.heldout, found.parameters, data.weights);
  }
  return j;
}

Json model_json(const model::ModelParameters& theta) {
  Json bodies = Json::array(), servos = Json::array();
  for (const model::BodyInertia& b : theta.body)
    bodies.push_back({{"mass_kg", b.mass}, {"com_m", b.com}, {"inertia_kgm2", b.inertia}});
  for (const model::ServoParameters& s : theta.servo)
    servos.push_back({{"stiffness_Nm_per_rad", s.stiffness},
                      {"damping_Nms_per_rad", s.damping},
                      {"armature_kgm2", s.armature},
                      {"coulomb_Nm", s.coulomb},
                      {"zero_rad", s.zero}});
  return {{"bodies", bodies},
          {"servos", servos},
          {"friction_forward", theta.friction_forward},
          {"friction_sideways", theta.friction_sideways},
          {"ground_height_m", theta.ground_height},
          {"target_lag_s", theta.target_lag_s}};
}

Json answer_of(const IdentifyOptions& options, const IdentificationData& data,
               const learn::Identification& found) {
  const learn::ParameterMap map = parameter_map();
  Json deviations;
  for (Eigen::Index i = 0; i < map.size(); ++i)
    deviations[map.names()[static_cast<std::size_t>(i)]] = found.z[i];
  return {{"motion", data.motion},
          {"seed", options.seed},
          {"population", options.population},
          {"generations", found.generations},
          {"loss", losses_json(data, found)},
          {"prior_deviations", deviations},
          {"model", model_json(found.parameters)}};
}

void print_answer(const Json& answer) {
  const Json& loss = answer["loss"];
  fmt::print("N-step loss on training trials {:.4g} -> {:.4g}\n",
             loss["training_initial"].get<double>(), loss["training"].get<double>());
  if (!loss["heldout"].is_null())
    fmt::print("            on held-out trials {:.4g} -> {:.4g}\n",
               loss["heldout_initial"].get<double>(), loss["heldout"].get<double>());
  fmt::print("{:<22} prior deviations from the initial model\n", "parameter");
  for (const auto& [name, z] : answer["prior_deviations"].items())
    fmt::print("{:<22} {:+6.2f}\n", name, z.get<double>());
}

}  // namespace

IdentificationData load_identification_data(const IdentifyOptions& options) {
  if (options.episodes.empty()) throw std::runtime_error("identify: no folder of a session given");
  prepare_folder(options);
  IdentificationData data;
  data.motion = motion_of(options);
  data.weights = motion::MotionLibrary().load(data.motion).weights.state;
  for (const fs::path& given : options.episodes) add_folder(given, data);
  for (const std::uint64_t number : {options.seed, static_cast<std::uint64_t>(options.population)})
    data.fingerprint = learn::mixed(data.fingerprint ^ number);
  mix(data.fingerprint, data.motion);
  const learn::ParameterMap map = parameter_map();
  for (const std::string& name : map.names()) mix(data.fingerprint, name);
  return data;
}

learn::Identification search_parameters(const IdentifyOptions& options,
                                        const IdentificationData& data,
                                        const std::function<bool()>& stop,
                                        const learn::DistributeCandidates& distribute,
                                        bool stores) {
  learn::IdentifyRun run;
  run.distribute = distribute;
  if (options.resume)
    run.continue_from = learn::load_search(state_file(options.out), data.fingerprint);
  const int done_before = run.continue_from ? run.continue_from->generation : 0;
  std::optional<learn::Progress> progress;
  if (!options.quiet) progress.emplace(stderr, "identify", options.generations, done_before);
  run.after_generation = [&](const learn::CrossEntropyState& state) {
    if (stores && !options.out.empty())
      learn::save_search(state_file(options.out), state, data.fingerprint);
    if (progress) progress->update(state.generation, fmt::format("loss {:.4g}", state.best_loss));
    return !stop();
  };
  return learn::identify(data.train, parameter_map(), model::make_plane(), data.weights,
                         settings_of(options), options.seed, run);
}

std::string identification_json(const IdentifyOptions& options, const IdentificationData& data,
                                const learn::Identification& found) {
  return answer_of(options, data, found).dump(1) + "\n";
}

int identify(const IdentifyOptions& options) {
  const IdentificationData data = load_identification_data(options);
  const Interrupt interrupt;
  const learn::Identification found = search_parameters(options, data, Interrupt::requested);
  const Json answer = answer_of(options, data, found);
  if (!options.out.empty())
    files::write_atomically(options.out / "identification.json", answer.dump(1) + "\n");
  if (!options.quiet) print_answer(answer);
  if (found.generations < options.generations) {
    fmt::print(stderr,
               "stopped after generation {} of {}; the same command with --resume goes on\n",
               found.generations, options.generations);
    return 2;
  }
  const Json& loss = answer["loss"];
  const bool judged = !loss["heldout"].is_null();
  return loss[judged ? "heldout" : "training"].get<double>() <
                 loss[judged ? "heldout_initial" : "training_initial"].get<double>()
             ? 0
             : 1;
}

}  // namespace sanso::app
