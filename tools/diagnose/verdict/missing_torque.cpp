// Missing torque of a window: with s the change of the shot's errors for one more N m at the joint,
// and M taking out the shot's start,
//
//   missing = -s'Mr / s'Ms,   sigma = 1 / sqrt(s'Ms)
#include "tools/diagnose/verdict/missing_torque.h"

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/compare/start_elimination.h"

namespace sanso::diagnose {
namespace {

/// Whitened change of every prediction for one more N m (or N) at a joint; all joints at once when
/// they hardly couple.
Eigen::VectorXd torque_signature(const Problem& problem, const Library& library, const Model& model,
                                 std::optional<std::size_t> joint, const Eigen::VectorXd& base,
                                 double torque) {
  Library with = library;
  Candidate push;
  push.apply = [joint](SimParams& p, const std::vector<double>& theta) {
    for (std::size_t j = 0; j < p.joints.size(); ++j) {
      if (!joint || *joint == j) p.joints[j].spring_torque += theta[0];
    }
  };
  with.candidates.push_back(std::move(push));
  Model moved = model;
  moved.effects.push_back({with.candidates.size() - 1, {torque}});
  return (prediction_error(problem, with, moved) - base) / torque;
}

TorqueSample describe(const Comparison& comparison, const Shot& shot, std::size_t joint,
                      const Prediction* replayed) {
  const Source& source = comparison.sources[shot.source];
  TorqueSample s;
  s.source = shot.source;
  s.joint = joint;
  s.row = shot.window.first;
  const std::vector<double>& command = source.drive.joints[joint].command;
  const Actuator actuator = source.nominal.joints[joint].nominal.actuator;
  const bool goal = actuator == Actuator::dc_servo || actuator == Actuator::position_pd;
  double n = 0.0;
  for (std::size_t k = shot.window.first; k <= shot.window.last; ++k, n += 1.0) {
    s.t += source.drive.t[k];
    s.q += source.motion.q[joint][k];
    s.dq += source.motion.dq[joint][k];
    if (goal && k < command.size() && std::isfinite(command[k]))
      s.error += command[k] - source.motion.q[joint][k];
    if (replayed != nullptr) s.motor += replayed->of(replayed->tau, joint)[k - shot.window.first];
  }
  s.t /= n, s.q /= n, s.dq /= n, s.error /= n, s.motor /= n;
  const double span = source.drive.t[shot.window.last] - source.drive.t[shot.window.first];
  s.ddq = (source.motion.dq[joint][shot.window.last] - source.motion.dq[joint][shot.window.first]) /
          std::max(span, 1e-9);
  return s;
}

}  // namespace

std::vector<TorqueSample> missing_torque(const std::vector<Source>& sources,
                                         const std::vector<NoiseLevel>& noise,
                                         const Library& library, const Model& model,
                                         const Settings& settings) {
  ProblemOptions options;
  options.shot_seconds = settings.data.torque_window;
  options.maximum_rows = settings.data.maximum_rows;
  options.secondary = false;
  const Problem problem = make_problem(sources, noise, options, settings);
  const Eigen::VectorXd base = prediction_error(problem, library, model);
  const StartElimination starts(problem, library, model);
  const Eigen::VectorXd error = starts.project(base);
  const std::size_t n = problem->joints.size();
  // as in StartElimination: beyond, only a joint's own rows answer for it
  const bool coupled = n <= static_cast<std::size_t>(settings.data.coupled_starts);
  std::vector<Eigen::VectorXd> raw(coupled ? n : 1);
  parallel_for(raw.size(), [&](std::size_t joint) {
    const double limit = problem->sources.front().nominal.joints[joint].nominal.torque_limit;
    raw[joint] =
        torque_signature(problem, library, model, coupled ? std::optional(joint) : std::nullopt,
                         base, limit > 0.0 ? 0.02 * limit : 0.05);
  });
  std::vector<std::vector<Prediction>> replay(problem->sources.size());
  std::vector<std::size_t> next(problem->sources.size(), 0);
  for (std::size_t s = 0; s < problem->sources.size(); ++s) {
    std::vector<Window> windows;
    for (const Shot& shot : problem->shots) {
      if (shot.source == s) windows.push_back(shot.window);
    }
    SimParams params = problem->sources[s].nominal;
    library.apply(model, params);
    SimOptions sim;
    sim.motion = &problem->sources[s].motion;
    sim.max_step_s = settings.fitting.search_step;
    replay[s] = simulate(params, problem->sources[s].drive, windows, sim);
  }
  std::vector<Eigen::VectorXd> projected;
  projected.reserve(raw.size());
  for (const Eigen::VectorXd& s : raw) projected.push_back(starts.project(s));
  std::vector<TorqueSample> out;
  for (const Shot& shot : problem->shots) {
    const Prediction* prediction = &replay[shot.source][next[shot.source]++];
    for (std::size_t c = 0; c < problem->channels.size(); ++c) {
      const std::size_t joint = problem->channels[c].joint;
      const std::size_t signature = coupled ? joint : 0;
      const auto change = rows_of(raw[signature], shot, c);
      const double norm = change.dot(rows_of(projected[signature], shot, c));
      if (!(norm > 1e-9)) continue;
      TorqueSample sample = describe(*problem, shot, joint, prediction);
      sample.missing = -change.dot(rows_of(error, shot, c)) / norm;
      sample.sigma = 1.0 / std::sqrt(norm);
      out.push_back(sample);
    }
  }
  return out;
}

}  // namespace sanso::diagnose
