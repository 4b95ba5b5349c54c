// Missing torque of a window: with s the change of the shot's errors for one more N m at the joint,
// and M taking out the shot's start,
//
//   missing = -s'Mr / s'Ms,   sigma = 1 / sqrt(s'Ms)
#include "tools/diagnose/verdict/missing_torque.h"

#include <Eigen/Core>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/compare/prediction_error.h"

namespace sanso::diagnose {
namespace {

/// Whitened change of every prediction for one more N m (or N) at a joint; all joints at once when
/// they hardly couple.
Eigen::VectorXd torque_signature(const Problem& problem, const Library& library, const Model& model,
                                 int joint, const Eigen::VectorXd& base, double torque) {
  Library with = library;
  Candidate push;
  push.apply = [joint](SimParams& p, const std::vector<double>& theta) {
    for (std::size_t j = 0; j < p.joints.size(); ++j) {
      if (joint < 0 || static_cast<std::size_t>(joint) == j) p.joints[j].spring_torque += theta[0];
    }
  };
  with.candidates.push_back(std::move(push));
  Model moved = model;
  moved.effects.push_back({static_cast<int>(with.candidates.size()) - 1, {torque}});
  return (prediction_error(problem, with, moved) - base) / torque;
}

TorqueSample describe(const Problem& problem, const Shot& shot, int joint,
                      const Prediction* replayed) {
  const Source& source = problem.sources[static_cast<std::size_t>(shot.source)];
  const auto j = static_cast<std::size_t>(joint);
  TorqueSample s;
  s.source = shot.source;
  s.joint = joint;
  s.row = shot.window.first;
  const std::vector<double>& command = source.drive.joints[j].command;
  const Actuator actuator = source.nominal.joints[j].nominal.actuator;
  const bool goal = actuator == Actuator::dc_servo || actuator == Actuator::position_pd;
  double n = 0.0;
  for (std::size_t k = shot.window.first; k <= shot.window.last; ++k, n += 1.0) {
    s.t += source.drive.t[k];
    s.q += source.motion.q[j][k];
    s.dq += source.motion.dq[j][k];
    if (goal && k < command.size() && std::isfinite(command[k]))
      s.error += command[k] - source.motion.q[j][k];
    if (replayed != nullptr) s.motor += replayed->of(replayed->tau, joint)[k - shot.window.first];
  }
  s.t /= n, s.q /= n, s.dq /= n, s.error /= n, s.motor /= n;
  const double span = source.drive.t[shot.window.last] - source.drive.t[shot.window.first];
  s.ddq = (source.motion.dq[j][shot.window.last] - source.motion.dq[j][shot.window.first]) /
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
  const int n = static_cast<int>(problem.joints.size());
  // as in StartElimination: beyond, only a joint's own rows answer for it
  const bool coupled = n <= settings.data.coupled_starts;
  std::vector<Eigen::VectorXd> raw(static_cast<std::size_t>(coupled ? n : 1));
  parallel_for(static_cast<int>(raw.size()), [&](int i) {
    const auto joint = static_cast<std::size_t>(i);
    const double limit = problem.sources.front().nominal.joints[joint].nominal.torque_limit;
    raw[joint] = torque_signature(problem, library, model, coupled ? i : -1, base,
                                  limit > 0.0 ? 0.02 * limit : 0.05);
  });
  std::vector<std::vector<Prediction>> replay(problem.sources.size());
  std::vector<std::size_t> next(problem.sources.size(), 0);
  for (std::size_t s = 0; s < problem.sources.size(); ++s) {
    std::vector<Window> windows;
    for (const Shot& shot : problem.shots) {
      if (shot.source == static_cast<int>(s)) windows.push_back(shot.window);
    }
    SimParams params = problem.sources[s].nominal;
    library.apply(model, params);
    SimOptions sim;
    sim.motion = &problem.sources[s].motion;
    sim.max_step_s = settings.fitting.search_step;
    replay[s] = simulate(params, problem.sources[s].drive, windows, sim);
  }
  std::vector<Eigen::VectorXd> projected;
  for (const Eigen::VectorXd& s : raw) projected.push_back(starts.project(s));
  std::vector<TorqueSample> out;
  for (const Shot& shot : problem.shots) {
    const auto source = static_cast<std::size_t>(shot.source);
    const Prediction* prediction = &replay[source][next[source]++];
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      const int joint = problem.channels[c].joint;
      const auto signature = static_cast<std::size_t>(coupled ? joint : 0);
      const auto from = static_cast<Eigen::Index>(shot.offset + c * shot.rows);
      const auto rows = static_cast<Eigen::Index>(shot.rows);
      const double norm =
          raw[signature].segment(from, rows).dot(projected[signature].segment(from, rows));
      if (!(norm > 1e-9)) continue;
      TorqueSample sample = describe(problem, shot, joint, prediction);
      sample.missing = -raw[signature].segment(from, rows).dot(error.segment(from, rows)) / norm;
      sample.sigma = 1.0 / std::sqrt(norm);
      out.push_back(sample);
    }
  }
  return out;
}

}  // namespace sanso::diagnose
