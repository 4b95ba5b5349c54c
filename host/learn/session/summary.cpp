// Field by field from the session's state; a field keeps its name and unit for good once it is
// in.
#include "host/learn/session/summary.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/learn/session/session.h"
#include "shared/files/atomic_file.h"
#include "shared/math/order_statistics.h"

namespace sanso::learn {
namespace {

using Json = nlohmann::ordered_json;

Json updates_json(const std::vector<float>& ms) {
  return {
      {"p50", percentile(ms, 0.5)}, {"p99", percentile(ms, 0.99)}, {"max", percentile(ms, 1.0)}};
}

/// Null where it was not computed: a trial that falls at once says nothing about a model, a real
/// robot nothing about the truth, a motion that lifts no foot nothing about lifts.
Json known(double value) { return value >= 0.0 ? Json(value) : Json(nullptr); }

Json iteration_json(const TrialSummary& s) {
  Json j{{"trial", s.trial},
         {"cost", s.cost},
         {"cost_true", known(s.cost_true)},
         {"failed", s.failed()},
         {"end", to_string(s.end)},
         {"succeeded", s.succeeded()},
         {"broken_clauses", s.broken_clauses},
         {"duration_s", s.duration_s},
         {"quiet_at_start", s.quiet_at_start},
         {"model_loss", known(s.model_loss)},
         {"model_loss_analytical", known(s.model_loss_analytical)},
         {"model_loss_initial", known(s.model_loss_initial)},
         {"residual_share", s.residual_share},
         {"sigma", s.sigma},
         {"input_share", s.input_share},
         {"lifted_share", known(s.lifted_share)},
         {"fault", s.fault},
         {"u_upper_rms_rad", s.u_upper_rms},
         {"u_middle_rms_rad", s.u_middle_rms},
         {"gain_upper", s.gain_upper},
         {"gain_middle", s.gain_middle},
         {"policy_update_ms", updates_json(s.update_ms)},
         {"late_updates", s.late_updates},
         {"bus_lost", s.bus_lost},
         {"bus_corrupt", s.bus_corrupt},
         {"wall_s", s.wall_s},
         {"digest", fmt::format("{:016x}", s.digest)}};
  return j;
}

Json without_json(const Layers& on) {
  Json out = Json::array();
  if (!on.lower) out.push_back("lower");
  if (!on.middle) out.push_back("middle");
  if (!on.upper) out.push_back("upper");
  if (!on.residual) out.push_back("residual");
  if (!on.stochastic) out.push_back("stochastic");
  return out;
}

}  // namespace

double percentile(std::vector<float> values, double p) {
  if (values.empty()) return 0.0;
  return math::quantile_nearest(std::span(values), p);
}

void write_summary(const std::filesystem::path& path, const std::string& motion,
                   const SessionSettings& settings, const SessionState& state,
                   const std::string& robot) {
  std::vector<float> updates;
  std::uint32_t late = 0;
  Json iterations = Json::array();
  for (const TrialSummary& s : state.history) {
    updates.insert(updates.end(), s.update_ms.begin(), s.update_ms.end());
    late += s.late_updates;
    iterations.push_back(iteration_json(s));
  }
  const Json summary{{"motion", motion},
                     {"seed", settings.seed},
                     {"world", settings.world},
                     {"robot", robot},
                     {"without", without_json(settings.layers)},
                     {"profile", settings.profile},
                     {"settings", settings.changed},
                     {"adopted", settings.adopted},
                     {"policy_update_ms", updates_json(updates)},
                     {"late_updates", late},
                     {"learned_digest", fmt::format("{:016x}", learned_digest(state))},
                     {"iterations", iterations}};
  files::write_atomically(path, summary.dump(1) + "\n");
}

}  // namespace sanso::learn
