// The servo's law along the recorded motion: torque, current or duty by replay, less the reading.
#include "tools/diagnose/explain/effort_law.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {
namespace {

/// The recorded motion is that of the sensors' clock: commands have to arrive later by the sensors'
/// delay.
SimParams in_sensor_time(SimParams params) {
  for (JointParams& joint : params.joints)
    joint.command_delay += joint.nominal.sensor_delay_s + joint.sensor_delay;
  return params;
}

const std::vector<double>& given(const ReplayTorques& replay, Signal signal) {
  return signal == Signal::pwm ? replay.duty : signal == Signal::i ? replay.current : replay.motor;
}

/// Writes the errors of one recording's shots.
void add_source(const Comparison& comparison, std::size_t index, const ReplayTorques& replay,
                Eigen::VectorXd& out) {
  const Source& source = comparison.sources[index];
  for (const Shot& shot : comparison.shots) {
    if (shot.source != index) continue;
    for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
      const Observed& channel = comparison.channels[c];
      if (!is_effort(channel.signal)) continue;
      const std::vector<double>& law = given(replay, channel.signal);
      auto errors = rows_of(out, shot, c);
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const std::size_t row = recorded_row(shot, k);
        const double difference =
            measured(source, channel, row) - law[channel.joint * replay.rows + row];
        if (std::isfinite(difference)) errors[k] = difference / channel.floor;
      }
    }
  }
}

}  // namespace

bool is_effort(Signal signal) {
  return signal == Signal::tau || signal == Signal::i || signal == Signal::pwm;
}

Eigen::VectorXd effort_error(const Comparison& comparison, const Library& library,
                             const Model& model) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(comparison.size);
  const bool any = std::any_of(comparison.channels.begin(), comparison.channels.end(),
                               [](const Observed& c) { return is_effort(c.signal); });
  if (!any) return out;
  std::vector<SimParams> params;
  std::vector<Replayed> recordings;
  params.reserve(comparison.sources.size());
  for (const Source& source : comparison.sources) {
    SimParams own = source.nominal;
    library.apply(model, own);
    params.push_back(in_sensor_time(std::move(own)));
    recordings.push_back({&params.back(), &source.drive, &source.motion});
  }
  SimOptions options;
  options.max_step_s = comparison.settings.fitting.search_step;
  const std::vector<ReplayTorques> replays = replay_torques(recordings, options);
  for (std::size_t i = 0; i < replays.size(); ++i) add_source(comparison, i, replays[i], out);
  return out;
}

}  // namespace sanso::diagnose
