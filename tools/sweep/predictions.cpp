// Rolls both models out from recorded states and writes JSON; nothing is fitted here.
#include "tools/sweep/predictions.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "host/learn/model/model_learner.h"
#include "host/learn/session/session_state.h"
#include "host/motion/motion.h"
#include "shared/files/atomic_file.h"
#include "shared/model/joints.h"

namespace sanso::sweep {
namespace {

using Json = nlohmann::ordered_json;

/// Entries of the state that are shown.
std::vector<std::pair<std::string, int>> channels() {
  std::vector<std::pair<std::string, int>> shown{{"base_y", model::kXPos + 1}};
  for (int j = 0; j < model::kNumJoints; ++j) {
    const std::string name = model::kJoints[j].name;
    if (name == "l_hip_roll" || name == "r_knee" || name == "l_ank_pitch")
      shown.emplace_back(name, model::kXJoint + j);
  }
  return shown;
}

host::AugmentedModel model_of(const std::filesystem::path& session, const motion::Motion& motion) {
  auto state = std::make_unique<learn::SessionState>();
  learn::load_state(session / "state.bin", *state);
  learn::ModelLearner learner({}, motion.weights.state, {}, 1);
  if (state->model_rounds > 0)
    learner.load(session / fmt::format("model_{:03d}.bin", state->model_rounds));
  learner.set_residual_trust(state->residual);
  return learner.current();
}

Json states_json(const std::vector<model::State>& states, double from_s) {
  Json out;
  for (std::size_t k = 0; k < states.size(); ++k)
    out["t"].push_back(from_s + 0.06 * static_cast<double>(k));
  for (const auto& [name, entry] : channels())
    for (const model::State& x : states) out[name].push_back(x[entry]);
  return out;
}

}  // namespace

int run_predictions(const PredictionOptions& options) {
  const motion::Motion motion = motion::MotionLibrary().load(options.motion);
  const learn::Episode episode = learn::load_episode(options.episode);
  const auto windows = learn::windows_of(episode, learn::kSpanTicks);
  if (windows.empty())
    throw std::runtime_error(options.episode.string() + ": no 0.72 s without a gap");
  Json recorded, models = Json::array();
  for (const wire::Observation& o : episode.ticks) {
    recorded["t"].push_back(to_seconds(kTickPeriod) * o.trial_tick);
    for (const auto& [name, entry] : channels()) recorded[name].push_back(o.x[entry]);
  }
  for (const std::filesystem::path& session : options.sessions) {
    const host::AugmentedModel m = model_of(session, motion);
    Json stretches = Json::array();
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const double from = to_seconds(kTickPeriod) * (episode.ticks.front().trial_tick +
                                                     static_cast<double>(i) * learn::kSpanTicks);
      stretches.push_back(states_json(
          learn::predicted(windows[i], m.analytical, m.ground, m.residual ? &*m.residual : nullptr),
          from));
    }
    models.push_back(
        {{"session", session.filename().string()},
         {"network", m.residual.has_value()},
         {"n_step_loss", learn::n_step_loss(windows, m.analytical, m.ground, motion.weights.state,
                                            m.residual ? &*m.residual : nullptr)},
         {"stretches", stretches}});
  }
  files::write_atomically(options.out / "predictions.json",
                          Json{{"recorded", recorded}, {"models", models}}.dump() + '\n');
  fmt::print("{}\n", (options.out / "predictions.json").string());
  return 0;
}

}  // namespace sanso::sweep
