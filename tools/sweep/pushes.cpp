// A push is drawn from its number alone, so that every rank and every choice of layers sees the
// same ones.
#include "tools/sweep/pushes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "host/app/interrupt.h"
#include "host/app/learn_command.h"
#include "host/app/learn_settings.h"
#include "host/learn/model/model_learner.h"
#include "host/learn/seeds.h"
#include "host/learn/session/session.h"
#include "host/motion/motion.h"
#include "shared/files/atomic_file.h"
#include "shared/policy/policy_bytes.h"
#include "tools/inprocess/inprocess_access.h"

namespace sanso::sweep {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kSurvival_s = 2.0;  // on its feet for so long after the push: survived
// short against the robot's 0.16 s of falling time: the impulse counts
constexpr double kDuration_s = 0.1;
constexpr double kHighest_m = 0.10;  // of the torso

/// What a session learned, ready to run again.
struct Learned {
  motion::Motion motion;
  learn::SessionState state;
  host::AugmentedModel model;
  std::vector<model::State> reference;
};

std::unique_ptr<Learned> load_learned(const PushOptions& options) {
  auto learned = std::make_unique<Learned>();
  learned->motion = motion::MotionLibrary().load(options.motion);
  learn::load_state(options.session / "state.bin", learned->state);
  if (!learned->state.identity.starts_with("motion " + options.motion + " "))
    throw std::runtime_error(fmt::format("{}: holds \"{}\", expected a session of motion {}",
                                         options.session.string(), learned->state.identity,
                                         options.motion));
  learn::ModelLearner learner({}, learned->motion.weights.state, {}, options.seed);
  if (learned->state.model_rounds > 0)
    learner.load(options.session / fmt::format("model_{:03d}.bin", learned->state.model_rounds));
  learner.set_residual_trust(learned->state.residual);
  learned->model = learner.current();
  learned->reference = learn::reference_of(learned->state.primitives);
  return learned;
}

inprocess::InProcessRobot::Push as_push(const DrawnPush& drawn) {
  const double force = drawn.impulse_Ns / drawn.duration_s;
  inprocess::InProcessRobot::Push push;
  push.trial_tick = static_cast<std::int32_t>(std::lround(drawn.time_s / to_seconds(kTickPeriod)));
  push.duration_s = drawn.duration_s;
  const double fx = force * std::cos(drawn.direction_rad),
               fy = force * std::sin(drawn.direction_rad);
  push.force_in_world_N = {fx, fy, 0.0};
  push.torque_in_world_Nm = {-drawn.height_m * fy, drawn.height_m * fx, 0.0};  // (0, 0, h) x f
  return push;
}

/// The walk until kSurvival_s after the push; it failed when the robot fell.
learn::Episode run_push(const Learned& learned, const PushOptions& options,
                        learn::TrialSettings settings, mpc::UpperLayer& upper,
                        const learn::Layers& layers, const DrawnPush& drawn, int number) {
  auto middle = std::make_unique<policy::MiddleTable>(learned.state.middle);
  middle->trial_id = 1;
  policy::round_to_wire(*middle);
  learn::TrialSetup setup;
  setup.primitives = &learned.state.primitives;
  setup.reference = learned.reference;
  setup.middle = middle.get();
  setup.weights = learned.motion.weights;
  setup.layers = layers;
  setup.sigma = learned.state.sigma;
  const int end = static_cast<int>(
      std::lround((drawn.time_s + drawn.duration_s + kSurvival_s) / to_seconds(kTickPeriod)));
  setup.duration_ticks = std::min(learned.state.primitives.duration_ticks(), end);
  settings.cost_limit = 1e9;  // a push costs; what counts is whether the robot falls
  settings.tilt_limit_rad = learned.motion.stop.tilt_limit_rad;
  settings.drop_limit_m = learned.motion.stop.drop_limit_m;

  inprocess::InProcessAccess access(options.world);
  const auto seed =
      learn::derived_seed(options.seed, static_cast<std::uint64_t>(number), learn::Stream::robot);
  link::RobotLink& link = access.place(learned.reference.front(), seed);
  learn::prepare_trial(link, setup, settings);
  access.robot().push_at(as_push(drawn));
  return learn::run_trial(link, upper, setup, settings);
}

std::vector<Json> run_mine(Ranks& ranks, const PushOptions& options, const Learned& learned) {
  app::LearnSettings settings;
  for (const std::string& change : options.changes) app::apply_setting(change, settings);
  settings.mpc.threads = 1;
  mpc::UpperLayer upper(settings.mpc, learned.model);
  const double from = learned.motion.window.from_s;
  const double to =
      std::min(learned.motion.window.to_s, learned.motion.duration_s() - kDuration_s - kSurvival_s);
  const int jobs = options.count * static_cast<int>(options.without.size());
  std::vector<Json> rows;
  for (int job = ranks.take_job(); job < jobs; job = ranks.take_job()) {
    const int number = job / static_cast<int>(options.without.size());
    const std::string& without =
        options.without[static_cast<std::size_t>(job) % options.without.size()];
    const auto layers =
        app::layers_without(without == "none" ? std::vector<std::string>{} : std::vector{without});
    const DrawnPush drawn =
        draw_push(options.seed, number, options.smallest_Ns, options.largest_Ns, from, to);
    const learn::Episode episode =
        run_push(learned, options, settings.session.trial, upper, layers, drawn, number);
    rows.push_back({{"push", number},
                    {"without", without},
                    {"impulse_Ns", drawn.impulse_Ns},
                    {"direction_rad", drawn.direction_rad},
                    {"height_m", drawn.height_m},
                    {"time_s", drawn.time_s},
                    {"survived", !episode.failed()},
                    {"end", learn::to_string(episode.end)},
                    {"fault", episode.fault}});
    if (app::Interrupt::requested()) ranks.take_no_more();
  }
  return rows;
}

}  // namespace

DrawnPush draw_push(std::uint64_t seed, int number, double smallest_Ns, double largest_Ns,
                    double from_s, double to_s) {
  std::mt19937_64 rng(
      learn::derived_seed(seed, static_cast<std::uint64_t>(number), learn::Stream::robot));
  // the top 53 bits as a fraction: the same on every machine, unlike the distributions of the
  // library
  const auto uniform = [&rng](double low, double high) {
    return low + (high - low) * 0x1p-53 * static_cast<double>(rng() >> 11);
  };
  DrawnPush push;
  push.duration_s = kDuration_s;
  push.impulse_Ns = uniform(smallest_Ns, largest_Ns);
  push.direction_rad = uniform(-M_PI, M_PI);
  push.height_m = uniform(0.0, kHighest_m);
  push.time_s = uniform(from_s, to_s);
  return push;
}

int run_pushes(Ranks& ranks, const PushOptions& options) {
  const app::Interrupt interrupt;
  if (options.smallest_Ns > options.largest_Ns)
    throw std::runtime_error(fmt::format("--smallest {}: expected at most --largest, {}",
                                         options.smallest_Ns, options.largest_Ns));
  const std::unique_ptr<Learned> learned = load_learned(options);
  const std::vector<Json> mine = run_mine(ranks, options, *learned);
  std::vector<Json> rows;
  for (const std::string& part : ranks.gather(Json(mine).dump()))
    for (const Json& row : Json::parse(part)) rows.push_back(row);
  const bool stopped = ranks.any(app::Interrupt::requested());
  if (ranks.rank() != 0) return 0;
  const std::size_t asked = static_cast<std::size_t>(options.count) * options.without.size();
  if (stopped && rows.size() < asked) {
    fmt::print(stderr, "sanso-sweep: stopped after {} of {} pushes; nothing is written\n",
               rows.size(), asked);
    return 2;
  }
  std::sort(rows.begin(), rows.end(), [](const Json& a, const Json& b) {
    return std::pair(a.at("without").get<std::string>(), a.at("push").get<int>()) <
           std::pair(b.at("without").get<std::string>(), b.at("push").get<int>());
  });
  const Json all{{"motion", options.motion},
                 {"world", options.world},
                 {"seed", options.seed},
                 {"set", options.changes},
                 {"pushes", rows}};
  files::write_atomically(options.out / "pushes.json", all.dump(1) + '\n');
  for (const std::string& without : options.without) {
    const auto survived = std::count_if(rows.begin(), rows.end(), [&](const Json& r) {
      return r.at("without") == without && r.at("survived").get<bool>();
    });
    fmt::print("{} without {}: {} of {} pushes survived\n", options.motion, without, survived,
               options.count);
  }
  fmt::print("{}\n", (options.out / "pushes.json").string());
  return 0;
}

}  // namespace sanso::sweep
