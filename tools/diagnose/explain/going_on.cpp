// Constant velocity as a rival of the whole model, joint by joint.
#include "tools/diagnose/explain/going_on.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "tools/diagnose/explain/steps.h"

namespace sanso::diagnose {
namespace {

/// Least squares of y = a + b t with priors on a and b, what is left of y'y + priors.
struct Line {
  double yy = 0.0, y = 0.0, ty = 0.0, n = 0.0, t = 0.0, tt = 0.0;
  void add(double at, double value) {
    yy += value * value, y += value, ty += at * value;
    n += 1.0, t += at, tt += at * at;
  }
  double left(double a_precision, double b_precision) const {
    Eigen::Matrix2d H;
    H << n + a_precision, t, t, tt + b_precision;
    const Eigen::Vector2d g(y, ty);
    return std::max(0.0, yy - g.dot(H.ldlt().solve(g)));
  }
};

double going_on(const Problem& problem, const Shot& shot, std::size_t c) {
  const Observed& channel = problem->channels[c];
  const Source& source = problem->sources[shot.source];
  const std::size_t j = channel.joint, first = shot.window.first;
  const double sigma = problem.scales.sigma[c];
  Line line;
  for (std::size_t k = 0; k < shot.rows; ++k) {
    const std::size_t row = recorded_row(shot, k);
    const double there = measured(source, channel, row);
    if (!std::isfinite(there)) continue;
    const double t = source.drive.t[row] - source.drive.t[first];
    line.add(t, (there - source.motion.q[j][first] - source.motion.dq[j][first] * t) / sigma);
  }
  const auto precision = [sigma](double deviation) {
    return sigma * sigma / std::max(deviation * deviation, 1e-18);
  };
  return line.left(precision(source.q_sigma[j][first]), precision(source.dq_sigma[j][first]));
}

bool of_joint(const Observed& channel, std::size_t joint) {
  return channel.signal == Signal::q && channel.joint == joint;
}

}  // namespace

Eigen::VectorXd going_on_energy(const Problem& problem, std::size_t joint) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem->shots.size()));
  for (std::size_t s = 0; s < problem->shots.size(); ++s) {
    for (std::size_t c = 0; c < problem->channels.size(); ++c) {
      if (of_joint(problem->channels[c], joint))
        out[static_cast<Eigen::Index>(s)] += going_on(problem, problem->shots[s], c);
    }
  }
  return out;
}

Eigen::VectorXd position_energy(const Surroundings& around, const Eigen::VectorXd& r,
                                std::size_t joint) {
  const Comparison& comparison = *around.problem;
  const Eigen::VectorXd projected = around.starts.project(r);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(comparison.shots.size()));
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    const Shot& shot = comparison.shots[s];
    for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
      if (!of_joint(comparison.channels[c], joint)) continue;
      const double energy = rows_of(r, shot, c).dot(rows_of(projected, shot, c));
      out[static_cast<Eigen::Index>(s)] += std::max(0.0, energy);
    }
  }
  return out;
}

void describe_what_going_on_beats(SearchState& state) {
  Selection& found = state.found;
  for (std::size_t i = 0; i < found.accepted.size(); ++i) {
    Accepted& entry = found.accepted[i];
    if (state.accepted(i).random) continue;
    std::vector<std::size_t> joints = state.accepted(i).joints;
    if (joints.empty()) {
      joints.resize(state.problem->joints.size());
      std::iota(joints.begin(), joints.end(), std::size_t{0});
    }
    const auto shots = static_cast<Eigen::Index>(state.problem->shots.size());
    Eigen::VectorXd with = Eigen::VectorXd::Zero(shots), going = with;
    for (const std::size_t j : joints) {
      with += position_energy(*found.around, found.final.r, j);
      going += going_on_energy(state.problem, j);
    }
    const HeldoutGain better = compare(*state.problem, with, going);
    if (better.certainty() <= state.decisions().standard_errors || !entry.contradicted.empty())
      continue;
    entry.contradicted = "a joint that goes on as it went is predicted better";
    state.say("kept as a description: " + state.accepted(i).title() + ", " + entry.contradicted);
  }
}

}  // namespace sanso::diagnose
