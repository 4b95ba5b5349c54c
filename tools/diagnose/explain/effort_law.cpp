// The servo's law along the recorded motion: torque, current or duty by replay, less the reading.
#include "tools/diagnose/explain/effort_law.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"

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

void add_source(const Problem& problem, const Library& library, const Model& model,
                std::size_t index, Eigen::VectorXd& out) {
  const Source& source = problem.sources[index];
  SimParams params = source.nominal;
  library.apply(model, params);
  SimOptions options;
  options.max_step_s = problem.settings.fitting.search_step;
  const ReplayTorques replay =
      replay_torques(in_sensor_time(std::move(params)), source.drive, source.motion, options);
  for (const Shot& shot : problem.shots) {
    if (shot.source != static_cast<int>(index)) continue;
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      const Observed& channel = problem.channels[c];
      if (!is_effort(channel.signal)) continue;
      const std::vector<double>& law = given(replay, channel.signal);
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const std::size_t row = shot.window.first + (k + 1) * static_cast<std::size_t>(shot.stride);
        const double difference = measured(source, channel, row) -
                                  law[static_cast<std::size_t>(channel.joint) * replay.rows + row];
        if (std::isfinite(difference))
          out[static_cast<Eigen::Index>(shot.offset + c * shot.rows + k)] =
              difference / channel.floor;
      }
    }
  }
}

}  // namespace

bool is_effort(Signal signal) {
  return signal == Signal::tau || signal == Signal::i || signal == Signal::pwm;
}

Eigen::VectorXd effort_error(const Problem& problem, const Library& library, const Model& model) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.size));
  const bool any = std::any_of(problem.channels.begin(), problem.channels.end(),
                               [](const Observed& c) { return is_effort(c.signal); });
  if (!any) return out;
  parallel_for(static_cast<int>(problem.sources.size()), [&](int i) {
    // every source writes its own shots
    add_source(problem, library, model, static_cast<std::size_t>(i), out);
  });
  return out;
}

}  // namespace sanso::diagnose
